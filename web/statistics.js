// SPDX-License-Identifier: Apache-2.0

// Errors of a picture, as docs/method.md defines them: relative root mean squares over all pixels
// and channels, sqrt(mean(e^2 / (r^2 + EPSILON))).
export const EPSILON = 0.01;

/** The noise that a picture's own variance claims, in parts of what another one shows. */
export function noiseAgainst({variance}, mean) {
  let sum = 0;
  for (let i = 0; i < mean.length; i++) sum += variance[i] / (mean[i] ** 2 + EPSILON);
  return Math.sqrt(sum / mean.length);
}

/** As the picture's own variance claims it. */
export const claimedError = picture => noiseAgainst(picture, picture.mean);

/** Against a reference of the same size. */
export function trueError({mean}, reference) {
  let sum = 0;
  for (let i = 0; i < mean.length; i++) sum += (mean[i] - reference[i]) ** 2 / (reference[i] ** 2 + EPSILON);
  return Math.sqrt(sum / mean.length);
}

/** Means over 2 x 2 pixels. */
export function halved(values, width, height) {
  const across = width / 2, result = new Float32Array(3 * across * height / 2);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++)
      for (let c = 0; c < 3; c++)
        result[3 * ((y >> 1) * across + (x >> 1)) + c] += values[3 * (y * width + x) + c] / 4;
  return result;
}
