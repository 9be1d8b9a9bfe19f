// SPDX-License-Identifier: Apache-2.0

'use strict';

// Pictures as the pages hold and show them: halves, compressed; sRGB; maps of what differs.
const RED = [202, 0, 32];
const BLUE = [5, 85, 176];  // both also in page.css, for the legend

function floatOfHalf(half) {
  const sign = half & 0x8000 ? -1 : 1, exponent = half >> 10 & 31, fraction = half & 1023;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (exponent ? (1 + fraction / 1024) * 2 ** (exponent - 15) : fraction * 2 ** -24);
}
const FLOATS = Float32Array.from({length: 65536}, (_, half) => floatOfHalf(half));

/** The planes of one encoded picture, as halves. */
async function decode(text, size) {
  const packed = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  return [0, 1, 2].map(plane => {
    const low = plane * 2 * size, high = low + size;
    return Uint16Array.from({length: size}, (_, i) => bytes[low + i] | bytes[high + i] << 8);
  });
}

const floatsOf = halves => Float32Array.from(halves, half => FLOATS[half]);

/** What sRGB byte shows radiance, of which 1 is white. */
function srgb(radiance) {
  const light = Math.min(Math.max(radiance, 0), 1);
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055);
}

function paint(canvas, colour) {
  const context = canvas.getContext('2d'), image = context.createImageData(canvas.width, canvas.height);
  for (let i = 0, byte = 0; byte < image.data.length; i++, byte += 4) {
    colour(i, image.data, byte);
    image.data[byte + 3] = 255;
  }
  context.putImageData(image, 0, 0);
}

/** Blue below 0, white at 0, red above; full colour from `scale` on. */
function paintMap(canvas, values, scale) {
  paint(canvas, (i, bytes, at) => {
    const strength = Math.min(Math.abs(values[i]) / scale, 1), end = values[i] > 0 ? RED : BLUE;
    for (let c = 0; c < 3; c++) bytes[at + c] = 255 + strength * (end[c] - 255);
  });
}

// The report takes this file without its exports.
export {BLUE, FLOATS, RED, decode, floatsOf, paint, paintMap, srgb};
