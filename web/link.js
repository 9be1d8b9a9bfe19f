// SPDX-License-Identifier: Apache-2.0

// A scene in a link: compressed JSON in the address's fragment. Files that are no text are {base64}.
const PREFIX = '#scene=';

async function piped(bytes, stream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

const toBase64 = bytes => btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
const toBytes = base64 => Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));

export async function fragmentOf(scene) {
  const text = JSON.stringify(scene, (_, value) => value instanceof Uint8Array ? {base64: toBase64(value)} : value);
  const letters = toBase64(await piped(new TextEncoder().encode(text), new CompressionStream('deflate')));
  return PREFIX + letters.replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** What fragmentOf() was given; null if the fragment holds no scene. Throws if it is damaged. */
export async function sceneOf(fragment) {
  if (!fragment.startsWith(PREFIX)) return null;
  const letters = fragment.slice(PREFIX.length).replaceAll('-', '+').replaceAll('_', '/');
  const text = new TextDecoder().decode(await piped(toBytes(letters), new DecompressionStream('deflate')));
  return JSON.parse(text, (_, value) => typeof value?.base64 === 'string' ? toBytes(value.base64) : value);
}
