// SPDX-License-Identifier: Apache-2.0

// The live page, as its users meet it. What it shows is compared, bit for bit, with what the core
// draws in Node of the scene that the page's address names.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, describe, it} from 'node:test';
import {fileURLToPath} from 'node:url';
import {EFFECTS} from '../../web/effects.js';
import {fragmentOf} from '../../web/link.js';
import {LivePage, launch, meanOf, pixelsWhere} from './live_page.js';
import {ROOT, filesOf} from './reference.js';

const PLUMB = fileURLToPath(new URL('build/plumb', ROOT));

// Parts of the seed scene's picture: x, then y.
const FLOOR_BY_RED_WALL = [[0.1, 0.2], [0.93, 0.97]];
const BACK_WALL = [[0.25, 0.35], [0.3, 0.5]];
const MATTE_SPHERE = [[0.66, 0.72], [0.5, 0.6]];
const MIDDLE = [[0.4, 0.6], [0.4, 0.6]];
const ALL = [[0, 1], [0, 1]];
const WALL_POINT = [0.3, 0.35];  // nothing to drag is there
const SPHERE_POINT = [0.69, 0.55];

export function testIn(name) {
  describe(`The live page in ${name}`, () => {
    const folder = mkdtempSync(join(tmpdir(), 'live_page-'));
    let browser = null;
    before(async () => { browser = await launch(name, folder); });
    after(async () => {
      await browser?.close();
      rmSync(folder, {recursive: true});
    });

    /** A test that begins with a page of its own. */
    const test = (title, body, options) => it(title, async t => {
      if (!browser) return t.skip(`${name} is not installed`);
      const live = await LivePage.open(browser, options);
      try {
        await body(live, t);
      } catch (error) {
        await live.page.close();
        throw error;
      }
      return live.close();
    });

    const fileOf = (file, text) => {
      const path = join(folder, file);
      writeFileSync(path, text);
      return path;
    };

    // -- Pictures

    test('draws by itself, more samples with time, as the core does in Node', async live => {
      const {samples} = await live.check();
      await live.picture(2 * samples);
      assert.equal(await live.trouble(), '');
    });

    test('draws the Cornell box, with its OBJ files', async live => {
      await live.change(() => live.choose('scene', 'cornell'));
      await live.check();
      assert.equal(await live.fragment(), '#cornell');
    });

    test('draws a ball of glass and one of steel', async live => {
      await live.change(() => live.choose('scene', 'spheres'));
      await live.check();
      assert.equal(await live.fragment(), '#spheres');
    });

    test('draws by each method and sampler', async live => {
      for (const changes of [{method: 'bsdf'}, {method: 'nee'}, {sampler: 'independent'}]) {
        const [[control, value]] = Object.entries(changes);
        const before = await live.control(control, 'A').then(select => select.evaluate(({value: old}) => old));
        await live.choose(control, value, 'A');
        await live.check(changes);
        await live.choose(control, before, 'A');
      }
    });

    test('shows direct light alone: the red wall colours the floor no more', async live => {
      const redness = picture => {
        const [red, green] = meanOf(picture, FLOOR_BY_RED_WALL);
        return red / green;
      };
      const all = await live.picture(32);
      await live.enter('last', 1, 'A');
      const direct = await live.check({bounces: [0, 1]}, 16);
      // The floor is white, and the lamp's light is 17 : 15.
      assert.ok(Math.abs(redness(direct) - 17 / 15) < 0.02, `${redness(direct)}`);
      assert.ok(redness(all) > 1.4, `${redness(all)}`);
      await live.enter('first', 1, 'A');
      const [lamp] = meanOf(await live.check({bounces: [1, 1]}), [[0.48, 0.52], [0.145, 0.155]]);
      assert.ok(lamp < 0.01, 'the lamp itself is still seen');
    });

    test('tells the error against the converged picture, and a bug raises its floor', async live => {
      const errorOf = async () => {
        const numbers = await live.numbers();
        return numbers['error against the converged picture'];
      };
      const {samples} = await live.picture(32), healthy = await errorOf();
      await live.chooseText('fault', 'webgl-demo', 'A');
      assert.match(await live.text('[data-of=A] .words'), /--fault webgl-demo/);
      await live.picture(samples);
      assert.ok(await errorOf() > 1.5 * healthy, `${await errorOf()}, ${healthy}`);
      await live.chooseText('fault', 'gamma-reflectance', 'A');
      await live.picture(samples);
      assert.ok(await errorOf() > 2 * healthy, `${await errorOf()}, ${healthy}`);
    }, {pixels: 256});

    test('plants each bug', async live => {
      const faults = live.core.faults();
      for (const fault of [faults.findIndex(([word]) => word === 'webgl-random'), 0]) {
        await live.choose('fault', fault, 'A');
        await live.check({fault});
      }
      const offered = await live.page.$$eval('[data-of=A] [name=fault] option', options => options.length);
      assert.equal(offered, faults.length + 1);
    });

    test('shows what light a wall has reflected', async live => {
      await live.choose('way', 'by', 'A');
      await live.choose('origin', 'left_wall', 'A');
      assert.equal(await live.text('[data-of=A] .words'), 'plumb render … --by left_wall');
      await live.check({light: {way: 'by', ids: ['left_wall']}});
    });

    test('compares two settings side by side', async live => {
      await live.click('compare');
      await live.enter('last', 0, 'B');
      await live.enter('exposure', 0.5);
      const dark = [[0.6, 0.9], [0.3, 0.9]];
      await live.page.waitForFunction(() => document.querySelectorAll('.numbers div').length === 8);
      let picture;
      do picture = await live.picture(4); while (meanOf(picture, dark)[0] > 0);
      assert.ok(meanOf(picture, BACK_WALL)[0] > 0.05);
      await live.page.$eval('#split', input => {
        input.value = 0.2;
        input.dispatchEvent(new Event('input', {bubbles: true}));
      });
      assert.equal(meanOf(await live.picture(4), BACK_WALL)[0], 0);
      await live.click('compare');
      await live.check();
    });

    test('shows what differs from other pictures', async live => {
      const {samples} = await live.picture(16);
      const colours = async () => {
        const [red, , blue] = meanOf(await live.picture(samples), ALL);
        return red - blue;
      };
      for (const [word, width] of [['plumbline', 256], ['povray', 128], ['cycles', 128]]) {
        await live.choose('show', word);
        live.width = width;
        assert.match(await live.text('.legend'), /^Red where/);
        const healthy = await colours();
        // Reflects more than it should.
        await live.chooseText('fault', 'gamma-reflectance', 'A');
        assert.ok(await colours() > healthy + 0.4, `${word}: ${healthy}, ${await colours()}`);
        await live.chooseText('fault', 'none', 'A');
      }
    }, {pixels: 256});

    test('exposes as it is told', async live => {
      await live.enter('exposure', 2);
      assert.equal(await live.text('[name=stops]'), '+2 stops');
      await live.check({}, 4, 2);
    });

    test('draws in three sizes', async live => {
      for (const size of [512, 256, 128]) {
        await live.choose('pixels', size);
        const {width, height} = await live.picture(1);
        assert.deepEqual([width, height], [size, size]);
      }
    });

    test('pauses, and goes on', async live => {
      await live.picture(4);
      await live.click('pause');
      const samplesAfter = async () => {
        await new Promise(resolve => { setTimeout(resolve, 300); });
        return live.page.evaluate(() => Number(document.body.dataset.samples));
      };
      await samplesAfter();  // passes that were under way
      const samples = await samplesAfter();
      assert.equal(await samplesAfter(), samples);
      await live.click('pause');
      await live.check({}, samples + 1);
    });

    // -- Things

    test('moves the lamp, and the shadows with it', async live => {
      await live.enter('last', 1, 'A');
      const before = await live.check({bounces: [0, 1]});
      await live.chooseText('selected', 'lamp');
      await live.change(() => live.enter('x', 100));
      await live.enter('last', 1, 'A');
      const now = await live.check({bounces: [0, 1]});
      const onFloor = pixel => pixel > 0.8 * 128 * 128;
      const lit = pixelsWhere(before, now, (a, b) => a === 0 && b > 100).filter(onFloor);
      const unlit = pixelsWhere(before, now, (a, b) => a > 100 && b === 0).filter(onFloor);
      assert.ok(lit.length > 30 && unlit.length > 30, `${lit.length} lit, ${unlit.length} unlit`);
    });

    test('makes the lamp brighter', async live => {
      const before = meanOf(await live.picture(16), BACK_WALL);
      await live.chooseText('selected', 'lamp');
      await live.change(() => live.enter('brightness', 8.5));
      const now = meanOf(await live.check({}, 16), BACK_WALL);
      before.forEach((light, c) => assert.ok(Math.abs(now[c] / light - 0.5) < 0.05, `${now[c] / light}`));
    });

    test('makes a matte thing steel, a steel one matte, and paints them', async live => {
      await live.chooseText('selected', 'matte_sphere');
      const matte = await live.picture(16);
      await live.change(() => live.click('material', 'steel'));
      const steel = await live.check({}, 16);
      assert.match((await live.scene()).xml, /specular_reflectance/);
      const changed = pixelsWhere(matte, steel, (a, b) => Math.abs(a - b) > 60).length;
      assert.ok(changed > 100, `${changed}`);
      await live.change(() => live.click('material', 'matte'));
      await live.change(() => live.enter('colour', '#0000ff'));
      const [red, green, blue] = meanOf(await live.check({}, 16), MATTE_SPHERE);
      assert.ok(blue > 0.01 && red < blue / 100 && green < blue / 100, `${[red, green, blue]}`);
      await live.chooseText('selected', 'steel_sphere');
      await live.change(() => live.click('material', 'matte'));
      await live.check();
    });

    test('makes a thing glass, bends light in it more or less, tints it, and makes it matte again', async live => {
      const control = async name => (await live.control(name)).evaluate(input => input.value);
      await live.chooseText('selected', 'matte_sphere');
      const matte = await live.picture(16);
      await live.change(() => live.click('material', 'glass'));
      assert.equal(await control('ior'), '1.5');
      assert.equal(await control('colour'), '#ffffff');
      const clear = await live.check({}, 16);
      assert.ok(pixelsWhere(matte, clear, (a, b) => Math.abs(a - b) > 60).length > 300);
      await live.change(() => live.enter('ior', 1.01));
      const faint = await live.check({}, 16);
      const through = picture => meanOf(picture, MATTE_SPHERE)[1];
      // As the back wall beside it.
      assert.ok(Math.abs(through(faint) / meanOf(faint, BACK_WALL)[1] - 1) < 0.3, `${through(faint)}`);
      await live.change(() => live.enter('colour', '#00ff00'));
      const [red, green] = meanOf(await live.check({}, 16), MATTE_SPHERE);
      assert.ok(green > 0.03 && red < green / 10, `${[red, green]}`);
      assert.equal(await control('ior'), '1.01');
      const other = await LivePage.open(browser, {fragment: await live.fragment()});
      await other.chooseText('selected', 'matte_sphere');
      for (const [name, value] of [['ior', '1.01'], ['colour', '#00ff00']])
        assert.equal(await (await other.control(name)).evaluate(input => input.value), value);
      await other.check();
      await other.close();
      await live.change(() => live.click('material', 'matte'));
      assert.equal(await live.page.$eval('.glass', label => label.hidden), true);
      await live.check();
    });

    test('keeps metals, tinted glass and bubbles as they are, until they are painted themselves', async live => {
      const {'scene.xml': metals} = await filesOf('metals');
      const glass = '<bsdf type="dielectric"><float name="int_ior" value="1.4"/><float name="ext_ior" value="1"/>' +
        '<rgb name="specular_transmittance" value="0.5, 0.9, 0.7"/></bsdf>';
      const bubble = '<boolean name="flip_normals" value="true"/>' + glass;
      const path = fileOf('materials.xml', metals.replace('<ref id="silver"/>', bubble).replace('type="conductor" id="copper">',
        'type="roughconductor" id="copper"><string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>'));
      await live.change(async () => (await live.control('open')).uploadFile(path));
      const gold = '<ref id="gold"/>', material = name => live.page.$eval(`[name=material][value=${name}]`, ({checked}) => checked);
      await live.chooseText('selected', 'silver_ball');
      assert.ok(await material('glass'));
      await live.change(() => live.enter('x', 130));
      await live.chooseText('selected', 'gold_ball');
      assert.ok(await material('metal'));
      await live.change(() => live.enter('size', 120));
      const {xml} = await live.scene();
      assert.ok(xml.includes(bubble) && xml.includes(gold));
      await live.check();
      await live.change(() => live.enter('colour', '#ff0000'));
      const painted = (await live.scene()).xml;
      assert.match(painted, /<rgb name="eta" value="0.143, 0.375, 1.442"\/><rgb name="k" value="3.983, 2.386, 1.603"\/><rgb name="specular_reflectance" value="1, 0, 0"/);
      await live.chooseText('selected', 'copper_ball');
      await live.change(() => live.enter('colour', '#00ff00'));
      assert.match((await live.scene()).xml, new RegExp('<bsdf type="roughconductor"><string name="distribution" value="ggx"/>' +
        '<float name="alpha" value="0.3"/><rgb name="eta" value="0.201, 0.924, 1.102"/>'));
      await live.change(() => live.click('material', 'steel'));
      assert.equal(await live.page.$eval('.metal', label => label.hidden), true);
      await live.check();
      await live.chooseText('selected', 'silver_ball');
      await live.change(() => live.enter('ior', 0.75));
      assert.doesNotMatch((await live.scene()).xml, /flip_normals/);
      assert.equal(await (await live.control('ior')).evaluate(input => input.value), '0.75');
      await live.check();
    });

    test('changes a thing’s size and place', async live => {
      await live.chooseText('selected', 'matte_cuboid');
      const before = await live.picture(8);
      await live.change(() => live.enter('size', 80));
      const small = await live.check({}, 8);
      assert.ok(pixelsWhere(before, small, (a, b) => Math.abs(a - b) > 60).length > 300);
      for (const [axis, value] of [['x', 300], ['y', 200], ['z', 100]]) {
        await live.change(() => live.enter(axis, value));
        await live.check();
        const shown = await (await live.control(axis)).evaluate(input => Number(input.value));
        assert.equal(shown, value);
      }
    });

    test('deletes a thing, and undoing restores the very picture', async live => {
      await live.chooseText('selected', 'matte_sphere');
      const before = await live.picture(8);
      await live.change(() => live.click('remove'));
      const without = await live.check({}, 8);
      assert.doesNotMatch((await live.scene()).xml, /id="matte_sphere"/);
      assert.ok(pixelsWhere(before, without, (a, b) => Math.abs(a - b) > 60).length > 300);
      await live.change(() => live.click('undo'));
      assert.equal(await live.fragment(), '#seed');
      await live.check();
      await live.change(() => live.click('redo'));
      await live.check();
      await live.change(async () => {
        await live.page.keyboard.down('Control');
        await live.page.keyboard.press('z');
        await live.page.keyboard.up('Control');
      });
      await live.check();
    });

    test('adds a sphere and a cuboid', async live => {
      for (const [control, id] of [['sphere', 'sphere_1'], ['cube', 'cuboid_1']]) {
        const before = await live.picture(8);
        await live.change(() => live.click(control));
        const now = await live.check({}, 8);
        assert.ok(pixelsWhere(before, now, (a, b) => Math.abs(a - b) > 30).length > 100, id);
        assert.ok((await live.scene()).xml.includes(`id="${id}"`));
        const selected = await live.control('selected');
        assert.equal(await selected.evaluate(select => select.selectedOptions[0].text), id);
        await live.change(() => live.enter('x', control === 'sphere' ? 400 : 200));
      }
    });

    test('drags a thing along the floor', async live => {
      const before = await live.picture(8);
      await live.change(() => live.drag(SPHERE_POINT, [0.5, 0.55]));
      const now = await live.check({}, 8), {xml} = await live.scene();
      const [, x, y, z] = xml.match(/id="matte_sphere">[^]*?<translate x="(\S+)" y="(\S+)" z="(\S+)"/).map(Number);
      // A fifth of the picture, which is 0.71 times its distance wide: 930 where the sphere is met.
      assert.ok(x > 115 && x < 140, `${x}`);
      assert.equal(y, 0);
      assert.ok(Math.abs(z) < 1e-3, `${z}`);
      assert.ok(pixelsWhere(before, now, (a, b) => Math.abs(a - b) > 60).length > 300);
      const selected = await live.control('selected');
      assert.equal(await selected.evaluate(select => select.selectedOptions[0].text), 'matte_sphere');
    });

    test('lets things be selected in the picture', async live => {
      await live.picture();
      const selected = await live.control('selected');
      const clicked = async (x, y) => {
        await live.page.mouse.click(...await live.at(x, y));
        return selected.evaluate(select => select.selectedOptions[0].text);
      };
      assert.equal(await clicked(...WALL_POINT), 'back_wall');
      assert.equal(await clicked(...SPHERE_POINT), 'matte_sphere');
      await live.page.keyboard.press('Escape');
      assert.equal(await selected.evaluate(select => select.value), '-1');
      await live.check();
    });

    // -- The view

    const originOf = async live => {
      const {xml} = await live.scene();
      return xml.match(/<lookat origin="([^"]*)"/)[1].split(',').map(Number);
    };

    test('goes around by drag, wheel and keys', async live => {
      await live.picture();
      await live.change(() => live.drag(WALL_POINT, [0.4, 0.35]));
      const dragged = await originOf(live);
      assert.ok(Math.abs(dragged[0] - 278) > 100 && Math.abs(dragged[1] - 274) < 1, `${dragged}`);
      await live.check();
      await live.change(() => live.drag(WALL_POINT, [0.4, 0.35], 'right'));
      await live.check();
      const far = await originOf(live);
      await live.page.mouse.move(...await live.at(...WALL_POINT));
      await live.change(() => live.page.mouse.wheel({deltaY: -200}));
      const near = await originOf(live);
      assert.ok(Math.abs(near[2] - 280) < 0.8 * Math.abs(far[2] - 280), `${near}, ${far}`);
      await live.check();
      await live.page.focus('#picture');
      for (const key of ['ArrowLeft', 'ArrowUp', '+', '-']) {
        await live.change(() => live.page.keyboard.press(key));
        await live.check();
      }
    });

    test('looks through the backs of walls', async live => {
      await live.picture();
      // Half around, 3 radians for a picture's width.
      await live.change(() => live.drag([0.03, 0.03], [0.97, 0.03]));
      assert.ok((await originOf(live))[2] > 1000);
      assert.ok(meanOf(await live.check({}, 8), MIDDLE)[1] > 0.02);
    });

    test('shows each effect, with and without the bounces that it takes', async live => {
      const buttons = await live.page.$$('#effects .buttons button');
      assert.equal(buttons.length, EFFECTS.length);
      for (const [i, {without: bounces}] of EFFECTS.entries()) {
        await live.change(() => buttons[i].click());
        assert.ok((await live.text('.told')).length > 50);
        const all = await live.check({}, 8);
        await live.click('without');
        const less = await live.check({bounces}, 8);
        assert.ok(meanOf(less, ALL)[1] < 0.9 * meanOf(all, ALL)[1]);
      }
    });

    // -- Files and links

    test('puts the scene into its address, from which another page opens it', async live => {
      await live.chooseText('selected', 'matte_cuboid');
      await live.change(() => live.enter('x', 200));
      const {xml} = await live.scene(), fragment = await live.fragment();
      await live.click('link');
      const other = await LivePage.open(browser, {fragment});
      await other.check();
      assert.equal((await other.scene()).xml, xml);
      await other.close();
    });

    test('says that an address is damaged', async live => {
      await live.check();
      assert.match(await live.trouble(), /damaged/);
      const other = await LivePage.open(browser, {fragment: await fragmentOf({base: 'seed', xml: '<scene/>'})});
      await other.picture();
      assert.match(await other.trouble(), /^scene\.xml:1: /);
      await other.close();
    }, {fragment: '#scene=A'});

    test('saves a scene that plumb renders', async (live, t) => {
      await live.chooseText('selected', 'matte_cuboid');
      await live.change(() => live.enter('x', 200));
      await live.click('save');
      await live.page.waitForFunction(() => document.querySelector('#said').textContent.startsWith('Saved'));
      const saved = join(folder, 'scene.xml'), {xml} = await live.scene();
      for (let tries = 0; !(existsSync(saved) && readFileSync(saved, 'utf8') === xml); tries++) {
        assert.ok(tries < 100, `no scene.xml among ${readdirSync(folder)}`);
        await new Promise(resolve => { setTimeout(resolve, 100); });
      }
      if (!existsSync(PLUMB)) return t.skip('build/plumb is not built');
      const {status, stderr} = spawnSync(PLUMB, ['render', saved, '--size', '64x64', '--spp', '4', '-o', join(folder, 'a.exr')]);
      assert.equal(status, 0, String(stderr));
      return undefined;
    });

    test('opens a scene with the OBJ files beside it', async live => {
      const files = await filesOf('cornell');
      const paths = Object.entries(files).map(([file, text]) => fileOf(file.replace('scene.xml', 'mine.xml'), text));
      await live.change(async () => (await live.control('open')).uploadFile(...paths));
      await live.check();
      assert.equal((await live.scene()).name, 'mine.xml');
    });

    test('opens a scene as it is: its bounces, a mirrored camera, a binary PLY beside it', async live => {
      const numbers = Float32Array.of(150, 100, 50, 200, 100, 50, 180, 150, 60);
      const face = Uint8Array.of(3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0);
      const header = 'ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n' +
        'property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n';
      const {'scene.xml': seed} = await filesOf('seed');
      const xml = seed.replace('<lookat', '<scale x="-1"/><lookat').replace('<sensor',
        '<integrator type="path"><integer name="max_depth" value="2"/></integrator>\n  <sensor').replace('</scene>',
        '<shape type="ply"><string name="filename" value="meshes/a.ply"/><boolean name="face_normals" value="true"/>' +
        '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>\n</scene>');
      const paths = [fileOf('mirrored.xml', xml), fileOf('a.ply', Buffer.concat([header, numbers, face].map(part =>
        typeof part === 'string' ? Buffer.from(part) : Buffer.from(part.buffer))))];
      const LEFT = [[0.03, 0.1], [0.4, 0.6]];
      await live.change(async () => (await live.control('open')).uploadFile(...paths));
      const isGreen = picture => meanOf(picture, LEFT)[1] > 2 * meanOf(picture, LEFT)[0];
      assert.ok(isGreen(await live.check({bounces: [0, 1]})));
      await live.page.focus('#picture');
      await live.change(() => live.page.keyboard.press('ArrowRight'));
      assert.ok(isGreen(await live.check({bounces: [0, 1]})));
      const other = await LivePage.open(browser, {fragment: await live.fragment()});
      await other.check({bounces: [0, 1]});
      await other.close();
    });

    test('undoes one step while the view still turns, and keeps the bounces that were chosen', async live => {
      await live.enter('last', 1, 'A');
      await live.chooseText('selected', 'matte_cuboid');
      await live.change(() => live.enter('x', 200));
      const {xml} = await live.scene();
      await live.page.focus('#picture');
      await live.page.keyboard.press('ArrowRight');
      await live.page.keyboard.down('Control');
      await live.page.keyboard.press('z');
      await live.page.keyboard.up('Control');
      await live.check({bounces: [0, 1]});
      assert.equal((await live.scene()).xml, xml);
    });

    test('refuses a file that is no scene, with the place, and keeps the picture', async live => {
      const path = fileOf('bad.xml', '<scene version="3.0.0">\n  <shape type="cone"/>\n</scene>\n');
      await live.picture();
      const refused = text => live.page.waitForFunction(wanted => {
        const trouble = document.querySelector('#trouble');
        return !trouble.hidden && trouble.textContent.includes(wanted);
      }, {}, text);
      await (await live.control('open')).uploadFile(path);
      await refused('bad.xml:2: ');
      assert.match(await live.trouble(), /cone/);
      const {samples} = await live.check();
      await live.check({}, samples + 1);
      const drop = (file, text) => live.page.evaluate((name, content) => {
        const data = new DataTransfer();
        data.items.add(new File([content], name));
        const event = type => new DragEvent(type, {dataTransfer: data, bubbles: true, cancelable: true});
        for (const type of ['dragover', 'drop']) document.body.dispatchEvent(event(type));
      }, file, text);
      await drop('worse.xml', 'no scene');
      await refused('worse.xml:1: ');
      await drop('notes.txt', 'no scene');
      await refused('no scene file');
      await live.check();
      const {'scene.xml': xml} = await filesOf('seed');
      await live.change(() => drop('dropped.xml', xml.replace('17, 15, 12', '3, 15, 12')));
      assert.equal(await live.trouble(), '');
      await live.check();
    });

    // -- Everybody

    test('needs no mouse', async live => {
      const {keyboard} = live.page;
      const tabTo = async wanted => {
        for (let tries = 0; tries < 60; tries++) {
          await keyboard.press('Tab');
          if (await live.page.evaluate(selector => document.activeElement.matches(selector), wanted)) return;
        }
        assert.fail(`Tab does not lead to ${wanted}`);
      };
      await live.picture();
      await live.page.evaluate(() => document.activeElement.blur());
      await tabTo('#picture');
      await live.change(() => keyboard.press('ArrowRight'));
      await live.check();
      await tabTo('[name=selected]');
      await keyboard.type('matte_s');
      await live.page.waitForFunction(() => document.activeElement.selectedOptions[0].text === 'matte_sphere');
      await tabTo('[name=x]');
      await live.change(async () => {
        await keyboard.down('Control');
        await keyboard.press('a');
        await keyboard.up('Control');
        await keyboard.type('300');
        await keyboard.press('Tab');
      });
      assert.match((await live.scene()).xml, /<translate x="158" y="0" z="0"/);
      await live.check();
      await tabTo('[name=remove]');
      await live.change(() => keyboard.press('Enter'));
      assert.doesNotMatch((await live.scene()).xml, /id="matte_sphere"/);
      await live.check();
    });

    test('fits a telephone', async live => {
      await live.page.setViewport({width: 390, height: 800});
      await live.page.waitForFunction(() => innerWidth === 390);
      await live.picture();
      await live.click('compare');
      await live.chooseText('selected', 'lamp');
      const widest = await live.page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(widest <= 390, `${widest}`);
      const unreachable = await live.page.$$eval('#picture, input, select, button', all => all.filter(control => {
        if (control.offsetParent === null || control.name === 'open') return false;
        control.scrollIntoView({block: 'center'});
        const {left, right, top, bottom} = control.getBoundingClientRect();
        const there = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
        return left < 0 || right > 390 || there !== control;
      }).map(({id, name}) => id || name));
      assert.deepEqual(unreachable, []);
    });

    it('says what is missing in an old browser', async t => {
      if (!browser) return t.skip(`${name} is not installed`);
      const live = await LivePage.open(browser, {pixels: 256, before: page =>
        page.evaluateOnNewDocument(() => { delete window.WebAssembly; })});
      await live.page.waitForFunction(() => !document.querySelector('#trouble').hidden);
      assert.match(await live.trouble(), /WebAssembly/);
      return live.close();
    });

    it('says that it needs its script', async t => {
      if (!browser) return t.skip(`${name} is not installed`);
      const html = readFileSync(new URL('out/plumbline.html', ROOT), 'utf8');
      assert.match(html, /<noscript>.*allow\s+it to run\.<\/p><\/noscript>/s);
      return undefined;
    });
  });
}
