// SPDX-License-Identifier: Apache-2.0

// What a page carries with it, packed: the core, its workers' code, and pictures.
import {FLOATS, decode} from '../report/pictures.js';

async function unpack(base64) {
  const bytes = Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The core as a WebAssembly.Module; throws an Error that says what the browser lacks. */
export async function compileCore(base64) {
  if (!('WebAssembly' in window) || !('DecompressionStream' in window))
    throw new Error('This browser lacks WebAssembly or cannot unpack what this page holds (DecompressionStream).');
  const bytes = await unpack(base64);
  if (!WebAssembly.validate(bytes))
    throw new Error('This browser’s WebAssembly lacks SIMD or exceptions, which the renderer needs.');
  return WebAssembly.compile(bytes);
}

/** One worker for each processor. */
export function startWorkers(code) {
  const address = URL.createObjectURL(new Blob([code], {type: 'text/javascript'}));
  const count = Math.min(Math.max(navigator.hardwareConcurrency || 2, 1), 32);
  return Array.from({length: count}, () => new Worker(address));
}

/** The radiance of a stored picture, in the layout of Core.mean(). */
export async function radianceOf({values, width, height}) {
  const planes = await decode(values, width * height);
  return Float32Array.from({length: 3 * planes[0].length}, (_, i) => FLOATS[planes[i % 3][i / 3 | 0]]);
}
