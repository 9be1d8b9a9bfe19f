// SPDX-License-Identifier: Apache-2.0

// What the page's pictures have to be: the core's own, drawn in Node.
import {readFile, readdir} from 'node:fs/promises';
import {Core} from '../../web/core.js';
import {showPictures} from '../../web/display.js';

export const ROOT = new URL('../../', import.meta.url);

const module = await WebAssembly.compile(await readFile(new URL('build-web/plumbline.wasm', ROOT)));
export const newCore = () => Core.create(module);

/** The texts of a reference scene, by their names. */
export async function filesOf(scene) {
  const folder = new URL(`reference_scenes/${scene}/`, ROOT);
  const names = (await readdir(folder)).filter(name => /\.(xml|obj)$/.test(name));
  return Object.fromEntries(await Promise.all(
    names.map(async name => [name, await readFile(new URL(name, folder), 'utf8')])));
}

/** As the page begins with them, but for some. */
export const settingsOf = changes => ({width: 256, height: 256, method: 'mis', sampler: 'sobol', seed: 1,
  bounces: [0, Infinity], fault: -1, light: null, ...changes});

/** A picture of the scene that the core holds: {settings, mean, variance}. */
export function draw(core, settings, samples, share) {
  core.begin(0, settings, share);
  core.render(0, 0, samples);
  const size = settings.width * settings.height;
  return {settings, mean: core.mean(0, size).slice(), variance: core.variance(0, size).slice()};
}

/** The bytes of its canvas, RGBA. */
export function bytesOf(picture, stops) {
  const canvas = {getContext: () => ({
    createImageData: (width, height) => ({data: new Uint8ClampedArray(4 * width * height)}),
    putImageData({data}) { canvas.bytes = data; },
  })};
  showPictures(canvas, picture, null, 1, stops);
  return canvas.bytes;
}
