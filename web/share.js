// SPDX-License-Identifier: Apache-2.0

// How a picture's values, three for each pixel, are divided among workers: chunks of 64 pixels, of
// which worker k of n has the k-th, the (k + n)-th and so on. core.cpp draws the same.
const CHUNK = 3 * 64;

function* chunks(length, [k, n]) {
  for (let begin = k * CHUNK; begin < length; begin += n * CHUNK)
    yield [begin, Math.min(begin + CHUNK, length)];
}

/** The share's values, one chunk after the other. */
export function gather(values, share) {
  const parts = [...chunks(values.length, share)];
  const gathered = new Float32Array(parts.reduce((sum, [begin, end]) => sum + end - begin, 0));
  let at = 0;
  for (const [begin, end] of parts) {
    gathered.set(values.subarray(begin, end), at);
    at += end - begin;
  }
  return gathered;
}

/** Puts what gather() gave into its place among all values. */
export function scatter(gathered, share, values) {
  let at = 0;
  for (const [begin, end] of chunks(values.length, share)) {
    values.set(gathered.subarray(at, at + end - begin), begin);
    at += end - begin;
  }
}
