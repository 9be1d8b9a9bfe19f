// SPDX-License-Identifier: Apache-2.0

// Draws pictures of a scene in all cores, pass by pass. Every worker draws its pixels of each pass;
// a picture is shown when all of them are there, so it has the same samples everywhere.
import {scatter} from './share.js';

const SECONDS_PER_PASS = 0.05;
const AHEAD = 2;  // passes that a worker may begin before the others have ended them

export class Renderer {
  /**
   * `workers` are Web Workers of worker.js. `onPicture(number, picture)` is called after each pass
   * with {settings, samples, seconds, mean, variance}; `onTrouble(text)` when a picture can't go on.
   */
  constructor(module, workers, onPicture, onTrouble) {
    this.workers = workers;
    this.onPicture = onPicture;
    this.onTrouble = onTrouble;
    this.pictures = new Map();
    this.generation = 0;
    this.isPaused = false;
    workers.forEach((worker, k) => {
      worker.isBusy = false;
      worker.onmessage = ({data}) => this.receive(worker, k, data);
      worker.onerror = event => onTrouble(event.message);
      worker.postMessage({act: 'init', module, share: [k, workers.length]});
    });
  }

  /** All pictures are of this scene from now on; they have to be begun anew. */
  setScene(files, name) {
    for (const number of [...this.pictures.keys()]) this.end(number);
    this.tell({act: 'scene', files, name});
  }

  begin(number, settings) {
    const generation = ++this.generation, size = 3 * settings.width * settings.height;
    this.pictures.set(number, {
      settings, generation, samples: 0, seconds: 0, passes: [], done: 0, last: 0, size: 1,
      next: this.workers.map(() => 0),
      mean: new Float32Array(size), variance: new Float32Array(size),
    });
    this.tell({act: 'begin', picture: number, generation, settings});
    this.feed();
  }

  end(number) {
    if (this.pictures.delete(number)) this.tell({act: 'end', picture: number});
  }

  pause(isPaused) {
    this.isPaused = isPaused;
    if (!isPaused) this.feed();
  }

  tell(message) { for (const worker of this.workers) worker.postMessage(message); }

  feed() { this.workers.forEach((worker, k) => this.give(worker, k)); }

  /** Gives an idle worker its part of a pass: of the picture that is farthest behind. */
  give(worker, k) {
    if (worker.isBusy || this.isPaused) return;
    const ready = [...this.pictures].filter(([, p]) => p.next[k] < p.done + AHEAD);
    if (ready.length === 0) return;
    const [picture, p] = ready.reduce((a, b) => b[1].seconds < a[1].seconds ? b : a);
    const pass = p.next[k]++;
    p.passes[pass] ??= {first: p.last, last: p.last += p.size, parts: 0, seconds: 0,
      mean: new Float32Array(p.mean.length), variance: new Float32Array(p.mean.length)};
    const {first, last} = p.passes[pass];
    worker.isBusy = true;
    worker.postMessage({act: 'pass', picture, generation: p.generation, pass, first, last});
  }

  receive(worker, k, data) {
    if (data.act === 'pass') worker.isBusy = false;
    const p = this.pictures.get(data.picture), isStale = p?.generation !== data.generation;
    if (data.trouble !== undefined && !isStale) {
      this.end(data.picture);
      this.onTrouble(data.trouble);
    } else if (data.mean !== undefined && !isStale) {
      this.collect(p, k, data);
    }
    this.feed();
  }

  collect(p, k, {picture, pass, mean, variance, seconds}) {
    const whole = p.passes[pass], share = [k, this.workers.length];
    scatter(mean, share, whole.mean);
    scatter(variance, share, whole.variance);
    whole.seconds += seconds / this.workers.length;
    if (++whole.parts < this.workers.length) return;
    const samples = whole.last - whole.first, pace = samples / Math.max(whole.seconds, 1e-4);
    p.size = Math.max(1, Math.min(Math.round(pace * SECONDS_PER_PASS), 4 * samples));
    p.samples = whole.last;
    p.seconds += whole.seconds;
    p.mean = whole.mean;
    p.variance = whole.variance;
    p.passes[pass] = undefined;
    p.done = pass + 1;
    this.onPicture(picture, p);
  }
}
