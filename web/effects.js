// SPDX-License-Identifier: Apache-2.0

// Where to look in the seed scene, and which bounces an effect takes. `without` are bounces that
// leave it out.
export const EFFECTS = [
  {
    title: 'Steel showing steel',
    look: {origin: [330, 250, -190], target: [380, 130, 260], up: [0, 1, 0]},
    without: [0, 1],
    text: 'The steel sphere shows the room, and in it the steel cuboid, which shows the room again. ' +
      'Light takes two or more mirror bounces on its way here: with one bounce at most, all that steel ' +
      'shows of other things is black.',
  },
  {
    title: 'The green wall, by way of sphere and cuboid',
    look: {origin: [410, 190, -120], target: [345, 105, 215], up: [0, 1, 0]},
    without: [0, 3],
    text: 'The green sliver in the right rim of the sphere is the green wall, seen first in the sphere and ' +
      'then in the cuboid’s front. The wall’s own light needs two further bounces from the lamp: four in all.',
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
    look: {origin: [240, 380, -200], target: [120, 150, 260], up: [0, 1, 0]},
    without: [2, 1000],
    text: 'A point near the edge of a shadow sees a part of the lamp, so the shadow fades: the wider, the ' +
      'farther it falls. Take the direct light away, and the shadows go with it.',
  },
];
