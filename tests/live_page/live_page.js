// SPDX-License-Identifier: Apache-2.0

// The live page in a browser, and what its pictures have to be.
import assert from 'node:assert/strict';
import {existsSync} from 'node:fs';
import puppeteer from 'puppeteer-core';
import {sceneOf} from '../../web/link.js';
import {ROOT, bytesOf, draw, filesOf, newCore, settingsOf} from './reference.js';

const PAGE = new URL('out/plumbline.html', ROOT).href;
const PLACES = {
  chrome: ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'],
  firefox: ['/usr/bin/firefox-esr', '/usr/bin/firefox'],
};
const PATIENCE = 60000;  // milliseconds

/** The browser, or null where it isn't installed or can't start. Saved files go to the folder. */
export async function launch(name, downloads) {
  const executablePath = PLACES[name].find(existsSync);
  if (!executablePath) return null;
  return puppeteer.launch({
    browser: name, executablePath, headless: true, args: name === 'chrome' ? ['--no-sandbox'] : [],
    downloadBehavior: name === 'chrome' ? {policy: 'allow', downloadPath: downloads} : undefined,
    extraPrefsFirefox: {'browser.download.folderList': 2, 'browser.download.dir': downloads,
      'browser.download.always_ask_before_handling_new_types': false},
  }).catch(error => {
    console.log(`${executablePath} does not start: ${error.message}`);
    return null;
  });
}

export class LivePage {
  /** Opens the page at an address's fragment; small pictures, as nothing here needs large ones. */
  static async open(browser, {fragment = '#seed', pixels = 128, before} = {}) {
    const live = new LivePage(), page = await browser.newPage();
    Object.assign(live, {page, width: 256, troubles: [], core: await newCore()});
    await page.setViewport({width: 1200, height: 900});
    page.on('console', message => message.type() === 'error' && live.troubles.push(message.text()));
    page.on('pageerror', error => live.troubles.push(error.message));
    page.on('request', request => {
      if (!/^(blob|data):/.test(request.url()) && request.url().split('#')[0] !== PAGE) live.troubles.push(request.url());
    });
    await before?.(page);
    await page.goto(PAGE + fragment);
    if (pixels !== 256) await live.choose('pixels', pixels);
    return live;
  }

  /** Closes the page. It has neither complained nor asked for anything. */
  async close() {
    await this.page.close();
    assert.deepEqual(this.troubles, []);
  }

  // -- Controls, by their names

  control(name, side) {
    return this.page.waitForSelector(`${side ? `[data-of=${side}] ` : ''}[name=${name}]`, {visible: name !== 'open'});
  }

  async choose(name, value, side) {
    const control = await this.control(name, side);
    await this.page.waitForFunction(select => select.options.length > 0, {timeout: PATIENCE}, control);
    await control.select(String(value));
    if (name === 'pixels') this.width = Number(value);
  }

  /** By a part of the option's text. */
  async chooseText(name, text, side) {
    const value = await (await this.control(name, side)).evaluate((select, wanted) =>
      [...select.options].find(option => option.text.includes(wanted))?.value, text);
    assert.notEqual(value, undefined, `${name} has no ${text}`);
    return this.choose(name, value, side);
  }

  async enter(name, value, side) {
    const control = await this.control(name, side);
    await control.evaluate((input, text) => {
      input.focus();
      input.value = text;
      for (const type of ['input', 'change']) input.dispatchEvent(new Event(type, {bubbles: true}));
      input.blur();
    }, String(value));
  }

  async click(name, value) {
    const control = await this.control(name + (value ? `][value=${value}` : ''));
    await control.click();
  }

  /** Does what leads to another scene, and waits until it is there and being drawn. */
  async change(act) {
    const before = await this.fragment();
    await act();
    await this.page.waitForFunction(old => location.hash !== old, {timeout: PATIENCE}, before);
  }

  fragment() { return this.page.evaluate(() => location.hash); }
  text(selector) { return this.page.$eval(selector, node => node.textContent); }
  trouble() { return this.page.$eval('#trouble', node => node.hidden ? '' : node.textContent); }

  /** The numbers beside the picture, by their names. */
  numbers() {
    return this.page.$$eval('.numbers div', rows => Object.fromEntries(rows.map(row =>
      [...row.children].map(node => node.textContent)).map(([name, value]) => [name, parseFloat(value)])));
  }

  // -- Pictures

  /** The canvas, as soon as it has so many samples: {samples, width, height, bytes}. */
  async picture(samples = 4) {
    const found = await this.page.waitForFunction((least, across) => {
      const canvas = document.querySelector('#picture'), {width, height} = canvas;
      const drawn = Number(document.body.dataset.samples);
      if (!(drawn >= least) || Math.max(width, height) !== across) return null;
      const bytes = canvas.getContext('2d').getImageData(0, 0, width, height).data;
      let letters = '';
      for (const byte of bytes) letters += String.fromCharCode(byte);
      return {samples: drawn, width, height, bytes: btoa(letters)};
    }, {polling: 'mutation', timeout: PATIENCE}, samples, this.width);
    const picture = await found.jsonValue();
    return {...picture, bytes: new Uint8ClampedArray(Buffer.from(picture.bytes, 'base64'))};
  }

  /** The scene that the address names: {files, name}. */
  async scene() {
    const fragment = await this.fragment(), scene = await sceneOf(fragment);
    if (!scene) return {files: await filesOf(fragment.slice(1)), name: 'scene.xml'};
    const {base, name, files, xml} = scene;
    return {files: {...base && await filesOf(base), ...files, [name]: xml}, name, xml};
  }

  /** Checks that the canvas shows the scene of the address, to the last bit; returns the picture. */
  async check(changes = {}, samples = 4, stops = 0.5) {
    const picture = await this.picture(samples), {files, name} = await this.scene();
    this.core.load(files, name);
    const {width, height} = picture;
    const drawn = draw(this.core, settingsOf({width, height, ...changes}), picture.samples);
    const wrong = bytesOf(drawn, stops).reduce((sum, byte, i) => sum + (byte !== picture.bytes[i]), 0);
    assert.equal(wrong, 0, `${wrong} bytes differ at ${picture.samples} samples`);
    return picture;
  }

  /** Where in the window a place of the picture is, from 0 to 1 each. */
  async at(x, y) {
    const canvas = await this.page.$('#picture');
    await canvas.scrollIntoView();
    const box = await canvas.boundingBox();
    return [box.x + x * box.width, box.y + y * box.height];
  }

  async drag(from, to, button = 'left') {
    const {mouse} = this.page, [start, end] = [await this.at(...from), await this.at(...to)];
    await mouse.move(...start);
    await mouse.down({button});
    await mouse.move(...end, {steps: 5});
    await mouse.up({button});
  }
}

/** Linear RGB, mean over a part of a picture: from and to where in x, then in y, from 0 to 1. */
export function meanOf({width, height, bytes}, [[x0, x1], [y0, y1]]) {
  const sum = [0, 0, 0];
  let count = 0;
  for (let y = Math.floor(y0 * height); y < y1 * height; y++) {
    for (let x = Math.floor(x0 * width); x < x1 * width; x++, count++) {
      for (let c = 0; c < 3; c++) {
        const code = bytes[4 * (y * width + x) + c] / 255;
        sum[c] += code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;
      }
    }
  }
  return sum.map(total => total / count);
}

/** The pixels, as numbers, in which `test(a, b)` holds for the sums of their bytes. */
export function pixelsWhere(a, b, test) {
  const light = ({bytes}, i) => bytes[4 * i] + bytes[4 * i + 1] + bytes[4 * i + 2];
  return Array.from({length: a.width * a.height}, (_, i) => i).filter(i => test(light(a, i), light(b, i)));
}
