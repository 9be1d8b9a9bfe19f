// SPDX-License-Identifier: Apache-2.0

// Puts pictures onto the canvas: one, two that share it, or a map of what differs.
import {paint, paintMap, srgb} from '../report/pictures.js';
import {project} from './camera.js';
import {EPSILON} from './statistics.js';

export const FULL_COLOUR = 0.2;  // a relative difference that is shown in full colour

// What byte shows radiance from 0 to 1: a table is quicker than a power for each value.
const STEPS = 16384;
const TONES = Uint8ClampedArray.from({length: STEPS + 1}, (_, i) => srgb(i / STEPS));

/** `right` is shown to the right of `split`, from 0 to 1; both have the same size, or it is null. */
export function showPictures(canvas, left, right, split, stops) {
  const {width, height} = left.settings, factor = 2 ** stops * STEPS, edge = split * width;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
  paint(canvas, (i, bytes, at) => {
    const {mean} = right && i % width >= edge ? right : left;
    for (let c = 0; c < 3; c++) bytes[at + c] = TONES[Math.min(Math.max(mean[3 * i + c] * factor, 0), STEPS) | 0];
  });
}

/** Mean over the channels of (picture - reference) / (reference + EPSILON); layouts of Core.mean(). */
export function showDifference(canvas, width, height, picture, reference) {
  Object.assign(canvas, {width, height});
  const relative = Float32Array.from({length: width * height}, (_, i) => {
    let sum = 0;
    for (let k = 3 * i; k < 3 * i + 3; k++) sum += (picture[k] - reference[k]) / (reference[k] + EPSILON);
    return sum / 3;
  });
  paintMap(canvas, relative, FULL_COLOUR);
}

/** Outlines a box of the scene, and the line at which two pictures meet. */
export function showOverlay(canvas, {camera, box, split}) {
  const ratio = window.devicePixelRatio || 1;
  Object.assign(canvas, {width: canvas.clientWidth * ratio, height: canvas.clientHeight * ratio});
  const context = canvas.getContext('2d'), {width, height} = canvas;
  context.clearRect(0, 0, width, height);
  context.lineWidth = 1.5 * ratio;
  if (split !== null) {
    context.strokeStyle = '#fff';
    context.strokeRect(split * width, -2, 1, height + 4);
  }
  if (!box) return;
  const corners = Array.from({length: 8}, (_, i) =>
    project(camera, [0, 1, 2].map(axis => (i >> axis & 1 ? box.high : box.low)[axis])));
  if (corners.some(corner => !corner.isBefore)) return;
  context.strokeStyle = '#ffd500';
  context.beginPath();
  for (let i = 0; i < 8; i++)
    for (let axis = 0; axis < 3; axis++)
      if (!(i >> axis & 1)) {
        const [a, b] = [corners[i], corners[i | 1 << axis]];
        context.moveTo(a.x * width, a.y * height);
        context.lineTo(b.x * width, b.y * height);
      }
  context.stroke();
}
