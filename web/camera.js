// SPDX-License-Identifier: Apache-2.0

// How a camera is led around what it looks at. Cameras are the core's: origin, and the unit vectors
// forward, right and up.
import {add, cross, dot, length, normalize, subtract, times, turn} from './vectors.js';

const MOST_TILT = 0.99;  // sine of the steepest view up or down

/** Where in the picture a point is seen, and whether it is before the camera. */
export function project(camera, point) {
  const to = subtract(point, camera.origin), depth = dot(to, camera.forward);
  return {x: (dot(to, camera.right) / depth / camera.halfWidth + 1) / 2,
    y: (1 - dot(to, camera.up) / depth / camera.halfHeight) / 2, isBefore: depth > 0};
}

/** The axis, 0 to 2, that points up in the picture, most nearly. */
export const upAxisOf = camera => camera.up.map(Math.abs).reduce((best, size, i, all) => size > all[best] ? i : best, 0);

const axisVector = (camera, axis) => [0, 1, 2].map(i => i === axis ? Math.sign(camera.up[axis]) || 1 : 0);

const isMirrored = camera => dot(cross(camera.forward, camera.up), camera.right) < 0;

/** The camera with another origin and direction, upright. */
function aim(camera, origin, forward, axis) {
  const up = axisVector(camera, axis);
  // What was to the right stays there.
  const hand = isMirrored(camera) ? -1 : 1;
  const right = times(normalize(cross(forward, up)), hand);
  const upright = times(cross(right, forward), hand);
  return {...camera, origin, forward, right, up: upright};
}

/** Around a pivot, by angles in radians to the left and down. */
export function orbit(camera, pivot, left, down, axis) {
  const up = axisVector(camera, axis), arm = subtract(camera.origin, pivot);
  const rotate = v => {
    const turned = turn(v, up, left);
    const side = turn(camera.right, up, left);
    return turn(turned, side, down);
  };
  const forward = normalize(rotate(camera.forward));
  if (Math.abs(dot(forward, up)) > MOST_TILT && Math.abs(dot(forward, up)) > Math.abs(dot(camera.forward, up)))
    return camera;
  return aim(camera, add(pivot, rotate(arm)), forward, axis);
}

/** Sideways and up, in parts of the picture's width at the distance of the pivot. */
export function pan(camera, pivot, right, up) {
  const width = 2 * camera.halfWidth * Math.max(dot(subtract(pivot, camera.origin), camera.forward), 1e-9);
  return {...camera,
    origin: add(camera.origin, add(times(camera.right, right * width), times(camera.up, up * width)))};
}

/** Nearer to the pivot, by a factor below 1, or away from it. */
export const zoom = (camera, pivot, factor) =>
  ({...camera, origin: add(pivot, times(subtract(camera.origin, pivot), factor))});

/** What a <lookat> says of it. */
export const lookAt = (camera, pivot) => ({origin: camera.origin, up: camera.up, isMirrored: isMirrored(camera),
  target: add(camera.origin, times(camera.forward, length(subtract(pivot, camera.origin))))});
