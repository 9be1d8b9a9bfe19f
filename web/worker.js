// SPDX-License-Identifier: Apache-2.0

// A web worker that draws its share of the pixels of one or two pictures, pass by pass.
import {Core} from './core.js';
import {gather} from './share.js';

let core, share;
const pictures = new Map();  // number: {generation, size}

const acts = {
  async init(message) {
    share = message.share;
    core = await Core.create(message.module);
  },
  scene({files, name}) { core.load(files, name); },
  begin({picture, generation, settings}) {
    pictures.delete(picture);
    core.begin(picture, settings, share);
    pictures.set(picture, {generation, size: settings.width * settings.height});
  },
  end({picture}) {
    pictures.delete(picture);
    core.end(picture);
  },
  pass({picture, generation, pass, first, last}) {
    const drawn = pictures.get(picture);
    if (drawn?.generation !== generation) return {};
    const start = performance.now();
    core.render(picture, first, last);
    const mean = gather(core.mean(picture, drawn.size), share);
    const variance = gather(core.variance(picture, drawn.size), share);
    return {pass, mean, variance, seconds: (performance.now() - start) / 1000};
  },
};

// Every message is answered by one, in their order.
async function answer({act, picture, generation, ...message}) {
  const head = {act, picture, generation};
  try {
    const result = await acts[act]({picture, generation, ...message});
    postMessage({...head, ...result}, result?.mean ? [result.mean.buffer, result.variance.buffer] : []);
  } catch (error) {
    postMessage({...head, trouble: String(error.message ?? error)});
  }
}

let before = Promise.resolve();
onmessage = ({data}) => { before = before.then(() => answer(data)); };
