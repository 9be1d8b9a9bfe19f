// SPDX-License-Identifier: Apache-2.0

// A scene in a link: compressed JSON in the address's fragment.
const PREFIX = '#scene=';

async function piped(bytes, stream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function fragmentOf(scene) {
  const bytes = await piped(new TextEncoder().encode(JSON.stringify(scene)), new CompressionStream('deflate'));
  const letters = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
  return PREFIX + letters.replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** What fragmentOf() was given; null if the fragment holds no scene. Throws if it is damaged. */
export async function sceneOf(fragment) {
  if (!fragment.startsWith(PREFIX)) return null;
  const letters = fragment.slice(PREFIX.length).replaceAll('-', '+').replaceAll('_', '/');
  const bytes = Uint8Array.from(atob(letters), letter => letter.charCodeAt(0));
  return JSON.parse(new TextDecoder().decode(await piped(bytes, new DecompressionStream('deflate'))));
}
