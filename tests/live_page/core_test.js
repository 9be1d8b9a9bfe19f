// SPDX-License-Identifier: Apache-2.0

// The WebAssembly module, in Node.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {describe, it} from 'node:test';
import {fileURLToPath} from 'node:url';
import {CoreError} from '../../web/core.js';
import {gather, scatter} from '../../web/share.js';
import {claimedError, halved, trueError} from '../../web/statistics.js';
import {ROOT, draw, filesOf, newCore, settingsOf} from './reference.js';

const NATIVE = fileURLToPath(new URL('build/native_picture', ROOT));

const small = changes => settingsOf({width: 50, height: 37, ...changes});

async function coreWith(scene) {
  const core = await newCore();
  core.load(await filesOf(scene), 'scene.xml');
  return core;
}

/** A picture of the same renderer as a native program; null where it has other instructions. */
function nativePicture(scene, samples) {
  const folder = mkdtempSync(join(tmpdir(), 'live_page-')), file = join(folder, 'floats');
  try {
    const {status, stdout} = spawnSync(NATIVE,
      [fileURLToPath(new URL(`reference_scenes/${scene}/scene.xml`, ROOT)), samples, file]);
    if (status !== 0) return null;
    const {buffer} = new Uint8Array(readFileSync(file)), half = buffer.byteLength / 2;
    return {...JSON.parse(stdout), mean: new Float32Array(buffer, 0, half / 4), variance: new Float32Array(buffer, half)};
  } finally {
    rmSync(folder, {recursive: true});
  }
}

const differing = (a, b) => a.reduce((count, value, i) => count + !Object.is(value, b[i]), 0);

describe('The core', () => {
  for (const scene of ['cornell', 'seed', 'spheres', 'metals']) {
    it(`draws ${scene} with the bits of native code`, async t => {
      if (!existsSync(NATIVE)) return t.skip('build/native_picture is not built');
      const native = nativePicture(scene, 64);
      if (!native) return t.skip('this machine has no SSE4');
      const picture = draw(await coreWith(scene), settingsOf(), 64);
      assert.equal(native.mean.length, 196608);
      assert.equal(picture.mean.length, 196608);
      assert.equal(differing(picture.mean, native.mean), 0);
      assert.equal(differing(picture.variance, native.variance), 0);
      const claimed = claimedError(picture);
      assert.ok(Math.abs(claimed / native.relativeError - 1) < 1e-6, `${claimed}, ${native.relativeError}`);
      return undefined;
    });
  }

  it('draws the same bits in any number of shares', async () => {
    const core = await coreWith('seed'), whole = draw(core, small(), 8);
    for (const n of [1, 2, 3, 5]) {
      const together = {mean: new Float32Array(whole.mean.length), variance: new Float32Array(whole.mean.length)};
      for (let k = 0; k < n; k++) {
        const part = draw(core, small(), 8, [k, n]);
        for (const name of ['mean', 'variance']) scatter(gather(part[name], [k, n]), [k, n], together[name]);
      }
      assert.deepEqual(together.mean, whole.mean);
      assert.deepEqual(together.variance, whole.variance);
    }
  });

  it('draws the same bits in any passes', async () => {
    const core = await coreWith('cornell'), size = 50 * 37;
    for (const sampler of ['sobol', 'independent']) {
      const settings = small({sampler}), whole = draw(core, settings, 64);
      core.begin(1, settings);
      for (const [first, last] of [[0, 1], [1, 8], [8, 13], [13, 64]]) core.render(1, first, last);
      assert.deepEqual(core.mean(1, size).slice(), whole.mean);
      assert.deepEqual(core.variance(1, size).slice(), whole.variance);
    }
  });

  it('draws two pictures by turns', async () => {
    const core = await coreWith('seed'), size = 50 * 37;
    const whole = ['mis', 'bsdf'].map(method => draw(core, small({method}), 8).mean);
    ['mis', 'bsdf'].forEach((method, i) => core.begin(i + 1, small({method})));
    for (const [first, last] of [[0, 3], [3, 8]]) for (const number of [1, 2]) core.render(number, first, last);
    assert.deepEqual([1, 2].map(number => core.mean(number, size).slice()), whole);
  });

  it('changes the picture by each fault', async () => {
    const core = await newCore(), {'scene.xml': seed} = await filesOf('seed');
    // Bright enough for what is clamped, and with glass that reflects totally.
    const glass = seed.replace(/(id="steel_cuboid"[^]*?)<ref id="steel"\/>/, '$1<bsdf type="dielectric"/>');
    core.load({'scene.xml': glass.replace('17, 15, 12', '170, 150, 120')}, 'scene.xml');
    const healthy = draw(core, small(), 256).mean;
    assert.equal(core.faults().length, 20);
    core.faults().forEach(([name, text], fault) => {
      assert.match(name, /^[a-z-]+$/);
      assert.ok(text.length > 10, text);
      assert.notEqual(differing(draw(core, small({fault}), 256).mean, healthy), 0, name);
    });
    assert.deepEqual(draw(core, small(), 256).mean, healthy);
  });

  it('draws light from some shapes alone, which adds up to all', async () => {
    const core = await coreWith('cornell'), ids = core.load(await filesOf('cornell'), 'scene.xml').shapes.map(({id}) => id);
    const whole = draw(core, small(), 16).mean;
    const parts = ids.map(id => draw(core, small({light: {way: 'from', ids: [id]}}), 16).mean);
    const most = whole.reduce((worst, value, i) =>
      Math.max(worst, Math.abs(parts.reduce((sum, part) => sum + part[i], -value)) / (value + 1)), 0);
    assert.ok(most < 1e-5, `${most}`);
    // What the red wall has reflected is red.
    const red = draw(core, small({light: {way: 'by', ids: ['left_wall']}}), 16).mean;
    const [r, g] = [0, 1].map(c => red.reduce((sum, value, i) => i % 3 === c ? sum + value : sum, 0));
    assert.ok(r > 5 * g && g > 0, `${r} ${g}`);
    assert.deepEqual(draw(core, small(), 16).mean, whole);
    const light = {way: 'by', ids: ['no_wall']};
    assert.throws(() => draw(core, small({light}), 1), /no_wall/);
    const fault = core.faults().findIndex(([name]) => name === 'webgl-demo');
    assert.throws(() => draw(core, small({light: {way: 'by', ids: ['floor']}, fault}), 1), /this bug/);
  });

  it('says what is wrong in a scene, and where, and keeps the one before', async () => {
    const core = await coreWith('seed'), before = draw(core, small(), 4).mean;
    const {'scene.xml': good} = await filesOf('seed');
    const refused = (files, message) => assert.throws(() => core.load(files, 'bad.xml'),
      error => error instanceof CoreError && message.test(error.message));
    refused({'bad.xml': 'no scene'}, /^bad\.xml:1: 'no scene'/);
    refused({'bad.xml': good.replace('type="sphere"', 'type="cone"')},
      new RegExp(`^bad\\.xml:${good.slice(0, good.indexOf('type="sphere"')).split('\n').length}: .*cone`));
    refused({'bad.xml': good.replace('value="95"', 'value="minus ninety"')}, /^bad\.xml:\d+: .*minus ninety/);
    const {'scene.xml': cornell} = await filesOf('cornell');
    refused({'bad.xml': cornell}, /^bad\.xml:\d+: .*floor\.obj/);
    refused({'bad.xml': cornell.replaceAll('"obj"', '"ply"').replaceAll('.obj', '.ply'), 'floor.ply': 'ply'}, /^floor\.ply: the header /m);
    assert.deepEqual(draw(core, small(), 4).mean, before);
  });

  it('says that a path does not end', async () => {
    const core = await newCore(), {'scene.xml': seed} = await filesOf('seed');
    // From inside of a mirror ball that reflects all.
    const xml = seed.replace(/<shape[^]*<\/shape>/, `<shape type="sphere"><float name="radius" value="2000"/>
      <bsdf type="twosided"><bsdf type="conductor"><string name="material" value="none"/></bsdf></bsdf></shape>`);
    core.load({'scene.xml': xml}, 'scene.xml');
    assert.throws(() => draw(core, small(), 1), /does not end/);
  });

  it('picks what is seen', async () => {
    const core = await coreWith('seed'), {shapes} = core.load(await filesOf('seed'), 'scene.xml');
    const idAt = (x, y) => shapes[core.pick(x, y)?.shape]?.id;
    assert.equal(idAt(0.5, 0.05), 'ceiling');
    assert.equal(idAt(0.05, 0.5), 'left_wall');
    assert.equal(idAt(0.3, 0.75), 'steel_sphere');
    assert.equal(idAt(0.69, 0.55), 'matte_sphere');
  });
});

describe('Statistics', () => {
  it('follow their formulas', () => {
    const mean = Float32Array.of(0.5, 0, 2), variance = Float32Array.of(0.25, 0.0625, 1);
    const expected = Math.sqrt((0.25 / 0.26 + 0.0625 / 0.01 + 1 / 4.01) / 3);
    assert.ok(Math.abs(claimedError({mean, variance}) - expected) < 1e-12);
    // The same squares, as differences.
    assert.ok(Math.abs(trueError({mean: Float32Array.of(1, 0.25, 1)}, mean) - expected) < 1e-12);
  });

  it('halve a picture', () => {
    const values = Float32Array.from({length: 3 * 8}, (_, i) => i);  // 4 x 2
    assert.deepEqual([...halved(values, 4, 2)], [7.5, 8.5, 9.5, 13.5, 14.5, 15.5]);
  });
});
