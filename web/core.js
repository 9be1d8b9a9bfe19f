// SPDX-License-Identifier: Apache-2.0

// The renderer's core: one instance of the WebAssembly module, in a page, a worker or Node.

export const METHODS = ['bsdf', 'nee', 'mis'];
export const WAYS = ['from', 'by'];  // as `plumb render` has them
export const SAMPLERS = ['independent', 'sobol'];
export const MOST_BOUNCES = 2 ** 31 - 1;

/** What the core says of a scene that it can't read, or of a picture that it can't draw. */
export class CoreError extends Error {}

// What libc asks for: a clock, and somewhere to write its last words. All else is not there.
function systemOf(core) {
  const view = () => new DataView(core.exports.memory.buffer);
  const calls = {
    clock_time_get(clock, precision, at) {
      view().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
      return 0;
    },
    fd_write(file, list, count, written) {
      let size = 0;
      for (let i = 0; i < count; i++) {
        const [at, length] = [0, 4].map(offset => view().getUint32(list + 8 * i + offset, true));
        console.error(core.textAt(at, length));
        size += length;
      }
      view().setUint32(written, size, true);
      return 0;
    },
    proc_exit(code) { throw new Error(`the core ended with code ${code}`); },
  };
  const badFile = 8;
  return new Proxy(calls, {get: (known, name) => known[name] ?? (() => badFile)});
}

export class Core {
  /** Of a WebAssembly.Module. */
  static async create(module) {
    const core = new Core();
    const instance = await WebAssembly.instantiate(module, {wasi_snapshot_preview1: systemOf(core)});
    core.exports = instance.exports;
    core.exports._initialize();
    return core;
  }

  /** The faults that can be planted: [name, text] each. */
  faults() {
    this.exports.faults();
    return JSON.parse(this.answer());
  }

  /**
   * Reads the scene `files[name]` and the files that it names, texts or bytes, and no others. Returns its camera, shapes,
   * bounces and notes. Throws CoreError; the scene before remains then.
   */
  load(files, name) {
    for (const [file, text] of Object.entries(files)) {
      this.withBytes(file, (at, size) => this.withBytes(text, (bytes, count) =>
        this.exports.add_file(at, size, bytes, count)));
    }
    this.check(this.withBytes(name, (at, size) => this.exports.load(at, size)));
    return JSON.parse(this.answer());
  }

  /**
   * Begins the picture of that number anew. `light` in the settings is {way, ids}, of the light that came by way of these
   * shapes alone, or null. `share` is [k, n]: this core draws the k-th of every n
   * chunks of pixels.
   */
  begin(picture, settings, share = [0, 1]) {
    const {width, height, method, sampler, seed, bounces: [first, last], fault, light} = settings;
    this.check(this.withBytes(JSON.stringify(light?.ids ?? []), (ids, size) => this.exports.begin(
      picture, width, height, METHODS.indexOf(method), SAMPLERS.indexOf(sampler), seed, first,
      Math.min(last, MOST_BOUNCES), fault, WAYS.indexOf(light?.way), ids, size, ...share)));
  }

  /** Adds the samples from `first` to below `last`. */
  render(picture, first, last) { this.check(this.exports.render(picture, first, last)); }

  /** Mean radiance and its variance, RGB, rows from the top; valid until the next call. */
  mean(picture, size) { return this.floats(this.exports.mean(picture), 3 * size); }
  variance(picture, size) { return this.floats(this.exports.variance(picture), 3 * size); }

  end(picture) { this.exports.end(picture); }

  /** What is seen at a place, from 0 to 1 each: {shape, point, normal}, or null. */
  pick(x, y) {
    this.exports.pick(x, y);
    return JSON.parse(this.answer());
  }

  check(code) { if (code !== 0) throw new CoreError(this.answer()); }
  answer() { return this.textAt(this.exports.answer(), this.exports.answer_size()); }
  floats(at, count) { return new Float32Array(this.exports.memory.buffer, at, count); }
  textAt(at, size) {
    return new TextDecoder().decode(new Uint8Array(this.exports.memory.buffer, at, size));
  }
  withBytes(content, use) {
    const bytes = typeof content === 'string' ? new TextEncoder().encode(content) : content;
    const at = this.exports.allocate(bytes.length);
    if (at === 0 && bytes.length > 0) throw new Error('The core has no memory left.');
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
    const result = use(at, bytes.length);
    this.exports.release(at);
    return result;
  }
}
