// SPDX-License-Identifier: Apache-2.0

// Where to look in the seed scene, and which bounces an effect takes. `without` are bounces that
// leave it out.
export const EFFECTS = [
  {
    title: 'Steel showing steel',
    look: {origin: [330, 250, -190], target: [380, 130, 260], up: [0, 1, 0]},
    without: [0, 2],
    text: 'The steel sphere shows the steel cuboid, which shows the room: such light is reflected three times, by ' +
      'a wall, the cuboid and the sphere. With two bounces at most, the sphere shows the room but a black cuboid.',
  },
  {
    title: 'The green wall, by way of sphere and cuboid',
    look: {origin: [324, 181, -103], target: [345, 140, 168], up: [0, 1, 0]},
    without: [0, 2],
    text: 'In the right rim of the sphere stands the front of the cuboid, and it is green: it mirrors the green wall. ' +
      'Wall, cuboid and sphere are three bounces; take the third away, and the front is black.',
  },
  {
    title: 'Red on one side, green on the other',
    look: {origin: [142, 300, -240], target: [142, 235, 200], up: [0, 1, 0]},
    without: [0, 1],
    text: 'The matte sphere is white. The red wall lights it from the left and the green one from the ' +
      'right, with light that has been reflected at least once: with direct light alone, it is grey.',
  },
  {
    title: 'The corner that the lamp cannot reach',
    look: {origin: [90, 250, -60], target: [30, 10, 180], up: [0, 1, 0]},
    without: [0, 1],
    text: 'Between the matte cuboid and the green wall lies a strip of floor in the lamp’s shadow. All of its ' +
      'light has been reflected by something else before; take that away, and it is black.',
  },
  {
    title: 'Soft shadows',
    look: {origin: [330, 360, -260], target: [120, 150, 230], up: [0, 1, 0]},
    without: [2, 1000],
    text: 'A point near the edge of a shadow sees a part of the lamp, so the shadow fades: the wider, the ' +
      'farther it falls. Take the direct light away, and the shadows go with it.',
  },
];
