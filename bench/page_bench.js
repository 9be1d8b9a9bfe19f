// SPDX-License-Identifier: Apache-2.0

// Speed of the live page's core in one worker, in Node and in the browsers that are installed, beside
// the same instructions in native code:
//   node bench/page_bench.js
import {execFileSync} from 'node:child_process';
import {existsSync, readFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {ROOT, filesOf, newCore, settingsOf} from '../tests/live_page/reference.js';
import {launch} from '../tests/live_page/live_page.js';

const SAMPLES = 64, RENDERS = 3;
const pathOf = name => fileURLToPath(new URL(name, ROOT));

/** Seconds for all renders, after one to warm up. Runs in Node and, as text, in a browser's worker. */
function timed(core, settings, samples, renders) {
  let start;
  for (let i = -1; i < renders; i++) {
    if (i === 0) start = performance.now();
    core.begin(0, settings);
    core.render(0, 0, samples);
  }
  return (performance.now() - start) / 1000;
}

function tell(scene, where, seconds) {
  const {width, height} = settingsOf();
  const pace = RENDERS * SAMPLES * width * height / seconds / 1e6;
  console.log(`| ${scene}/mis/sobol/${where} | ${pace.toFixed(2)} |`);
}

function inNative(scene) {
  const program = pathOf('build/native_picture');
  if (!existsSync(program)) return;
  const file = join(tmpdir(), `page_bench-${process.pid}`);
  const paces = Array.from({length: RENDERS + 1}, () => JSON.parse(execFileSync(program,
    [pathOf(`reference_scenes/${scene}/scene.xml`), SAMPLES, file])).samplesPerSecond).slice(1);
  const {width, height} = settingsOf();
  tell(scene, 'native SSE4', paces.reduce((sum, pace) => sum + SAMPLES * width * height / pace, 0));
}

async function inNode(scene, files) {
  const core = await newCore();
  core.load(files, 'scene.xml');
  tell(scene, 'Node', timed(core, settingsOf(), SAMPLES, RENDERS));
}

/** In a worker of an empty page, of which core.js is the text. */
async function inBrowser(name, scenes) {
  const browser = await launch(name, tmpdir());
  if (!browser) return;
  const page = await browser.newPage();
  const source = readFileSync(pathOf('web/core.js'), 'utf8').replaceAll(/^export /gm, '') + timed + `
    onmessage = async ({data: {bytes, files, settings, samples, renders}}) => {
      const core = await Core.create(await WebAssembly.compile(Uint8Array.from(atob(bytes), c => c.charCodeAt(0))));
      core.load(files, 'scene.xml');
      postMessage(timed(core, settings, samples, renders));
    };`;
  const bytes = readFileSync(pathOf('build-web/plumbline.wasm')).toString('base64');
  for (const [scene, files] of Object.entries(scenes)) {
    const seconds = await page.evaluate((code, text) => new Promise((resolve, reject) => {
      const worker = new Worker(URL.createObjectURL(new Blob([code], {type: 'text/javascript'})));
      worker.onmessage = ({data}) => resolve(data);
      worker.onerror = event => reject(new Error(event.message));
      const job = JSON.parse(text);
      worker.postMessage({...job, settings: {...job.settings, bounces: [0, Infinity]}});
    }), source, JSON.stringify({bytes, files, settings: settingsOf(), samples: SAMPLES, renders: RENDERS}));
    tell(scene, `${await browser.version()}`.replace('/', ' '), seconds);
  }
  await browser.close();
}

const scenes = {};
for (const scene of ['cornell', 'seed']) scenes[scene] = await filesOf(scene);
console.log(`256x256, ${SAMPLES} samples per pixel, one core\n\n| scene/method/sampler/where | Msamples/s |\n|---|---|`);
for (const scene of Object.keys(scenes)) inNative(scene);
for (const [scene, files] of Object.entries(scenes)) await inNode(scene, files);
for (const name of ['chrome', 'firefox']) await inBrowser(name, scenes);
