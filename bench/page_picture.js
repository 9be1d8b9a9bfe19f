// SPDX-License-Identifier: Apache-2.0

// Takes the picture of the live page for README.md: node bench/page_picture.js docs/pictures/page.png
import {tmpdir} from 'node:os';
import {launch} from '../tests/live_page/live_page.js';
import {ROOT} from '../tests/live_page/reference.js';

const SAMPLES = 400;

const browser = await launch('chrome', tmpdir());
if (!browser) throw new Error('There is no Chromium here');
const page = await browser.newPage();
await page.setViewport({width: 1180, height: 1230});
await page.goto(new URL('out/plumbline.html#seed', ROOT).href);
await page.waitForFunction(most => Number(document.body.dataset.samples) >= most, {timeout: 120000}, SAMPLES);
await page.screenshot({path: process.argv[2]});
await browser.close();
