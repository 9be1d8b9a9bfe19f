// SPDX-License-Identifier: Apache-2.0

// Vectors of three numbers.

export const add = (a, b) => a.map((x, i) => x + b[i]);
export const subtract = (a, b) => a.map((x, i) => x - b[i]);
export const times = (a, s) => a.map(x => x * s);
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = a => Math.sqrt(dot(a, a));
export const normalize = a => times(a, 1 / length(a));
export const cross = (a, b) =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Turns a vector about a unit axis, by an angle in radians (Rodrigues). */
export const turn = (a, axis, angle) => add(
  add(times(a, Math.cos(angle)), times(cross(axis, a), Math.sin(angle))),
  times(axis, dot(axis, a) * (1 - Math.cos(angle))));
