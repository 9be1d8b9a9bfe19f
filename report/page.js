// SPDX-License-Identifier: Apache-2.0

'use strict';

const BLOCK = 8;
const MOST_ZOOM = 64;

// ---- Pictures ----------------------------------------------------------------------------------

const meanOf = planes => planes[0].map((_, i) => (planes[0][i] + planes[1][i] + planes[2][i]) / 3);

async function loadPicture(picture) {
  const size = picture.width * picture.height;
  picture.halves = await decode(picture.values, size);
  const planes = picture.halves.map(floatsOf);
  picture.planes = {R: planes[0], G: planes[1], B: planes[2], mean: meanOf(planes)};
  picture.noise = picture.errors ? meanOf((await decode(picture.errors, size)).map(floatsOf)) : null;
  picture.canvas = element('canvas', {width: picture.width, height: picture.height});
}

/** What sRGB byte each half shows at an exposure: a table is quicker than a power for each pixel. */
const toneTable = stops => Uint8ClampedArray.from(FLOATS, radiance => srgb(radiance * 2 ** stops));

function paintPicture(picture, tone) {
  const [red, green, blue] = picture.halves;
  paint(picture.canvas, (i, bytes, at) => {
    bytes[at] = tone[red[i]], bytes[at + 1] = tone[green[i]], bytes[at + 2] = tone[blue[i]];
  });
}

// ---- Maps: what differs, pixel by pixel --------------------------------------------------------

const squareOf = (noise, i) => noise ? noise[i] ** 2 : 0;
const score = (difference, variance) =>
  difference === 0 ? 0 : difference / Math.sqrt(variance);

const MAPS = {
  difference: (a, b, channel) =>
    a.planes[channel].map((value, i) => value - b.planes[channel][i]),

  z: (a, b) => a.planes.mean.map((value, i) =>
    score(value - b.planes.mean[i], squareOf(a.noise, i) + squareOf(b.noise, i))),

  block(a, b) {
    const across = Math.ceil(a.width / BLOCK);
    const blockOf = i => Math.floor(i / a.width / BLOCK) * across + Math.floor(i % a.width / BLOCK);
    // Count and size of a block cancel: the mean's z is the sum's.
    const difference = [], variance = [];
    a.planes.mean.forEach((value, i) => {
      const block = blockOf(i);
      difference[block] = (difference[block] ?? 0) + value - b.planes.mean[i];
      variance[block] = (variance[block] ?? 0) + squareOf(a.noise, i) + squareOf(b.noise, i);
    });
    return a.planes.mean.map((_, i) => score(difference[blockOf(i)], variance[blockOf(i)]));
  },
};

function whyNoMap(mode, a, b) {
  if (a.width !== b.width || a.height !== b.height)
    return `${a.title} has ${a.width} × ${a.height} pixels, ${b.title} ${b.width} × ${b.height}: ` +
      'only pictures of one size can be subtracted.';
  if (mode !== 'difference' && !a.noise && !b.noise)
    return 'The noise of neither picture is known, so a difference cannot be measured by it. ' +
      'The view “Difference” shows it as radiance.';
  return '';
}

const scaleOf = step => [1, 2, 5][(step % 3 + 3) % 3] * 10 ** Math.floor(step / 3);

/** The first of the scales 1, 2, 5, 10, … that holds 98 % of the values. */
function automaticStep(values, slider) {
  const sizes = values.map(Math.abs).filter(Number.isFinite).sort();
  const wanted = sizes[Math.floor(0.98 * (sizes.length - 1))] || sizes[sizes.length - 1] || 1;
  let step = Number(slider.min);
  while (step < Number(slider.max) && scaleOf(step) < wanted * (1 - 1e-6)) step++;
  return step;
}

// ---- Text --------------------------------------------------------------------------------------

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children.filter(child => child !== null && child !== undefined));
  return made;
}

const withMinus = text => text.replace(/-/g, '−');
const number = (value, digits = 4) => value === null || value === undefined ? '' : withMinus(
  value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e5) && Number.isFinite(value)
    ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits))));
const signed = (value, digits) => (value > 0 ? '+' : '') + number(value, digits);

// ---- Scenes ------------------------------------------------------------------------------------

/** Puts what compares its pictures into a scene's section. */
async function bringToLife(scene) {
  if (scene.pictures.length === 0) return;  // a check that ended before any was there
  await Promise.all(scene.pictures.map(loadPicture));
  const {section, pictures} = scene, form = document.getElementById('viewer').content.cloneNode(true).firstElementChild;
  section.querySelector('h3').before(form);
  scene.viewer = new Viewer(form, pictures);
  section.querySelectorAll('.pictures img').forEach((image, i) => image.replaceWith(pictures[i].canvas));
  for (const {cells} of section.querySelectorAll('.verdict > tr:first-child')) {
    const [a, b] = [0, 1].map(i => pictures.findIndex(({title}) => title === cells[i].textContent));
    if (a >= 0 && b >= 0)
      cells[4].append(element('button', {type: 'button', onclick: () => scene.viewer.choose(a, b)}, 'View'));
  }
}

// ---- The page ----------------------------------------------------------------------------------

function showScene(scenes) {
  const current = scenes.find(scene => `#${scene.name}` === decodeURIComponent(location.hash)) ?? scenes[0];
  for (const {section, tab} of scenes) {
    const isCurrent = section === current.section;
    section.hidden = !isCurrent;
    tab.setAttribute('aria-selected', isCurrent);
    tab.tabIndex = isCurrent ? 0 : -1;
  }
  current.viewer?.draw();
  return current;
}

/** Without a script all scenes are one page, and the tabs are links to their headings. */
function makeTabs(scenes) {
  const nav = document.querySelector('nav');
  nav.setAttribute('role', 'tablist');
  for (const scene of scenes) {
    scene.section = document.getElementById(scene.name);
    scene.tab = document.getElementById(`tab-${scene.name}`);
    scene.tab.setAttribute('role', 'tab');
    scene.tab.setAttribute('aria-controls', scene.name);
    scene.section.setAttribute('role', 'tabpanel');
    scene.section.setAttribute('aria-labelledby', scene.tab.id);
    // Not as a link, which would scroll there and take the focus from the tab.
    scene.tab.onclick = event => {
      event.preventDefault();
      history.pushState(null, '', `#${scene.name}`);
      onhashchange();
    };
  }
  nav.onkeydown = event => {
    const at = scenes.findIndex(({tab}) => tab === event.target), last = scenes.length - 1;
    const next = {ArrowLeft: at > 0 ? at - 1 : last, ArrowRight: at < last ? at + 1 : 0, Home: 0, End: last, ' ': at}[event.key];
    if (next === undefined) return;
    event.preventDefault();
    scenes[next].tab.focus();
    scenes[next].tab.click();
  };
}

function listenToPage(scenes) {
  let current = showScene(scenes), folds = [], modes = [];
  onhashchange = () => { current = showScene(scenes); };
  onkeydown = event => {
    const {target} = event, waits = event.key === ' ' && target.closest('button, summary, a');
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest('select') || waits) return;
    if (current.viewer?.act(event.key)) event.preventDefault();
  };
  // On paper there is nothing to click: all scenes, both pictures and all but long lists are seen.
  onbeforeprint = () => {
    folds = [...document.querySelectorAll('details:not([open])')].filter(fold => !fold.closest('.list'));
    folds.forEach(fold => { fold.open = true; });
    modes = scenes.map(({viewer}) => viewer?.mode);
    scenes.forEach(({section, viewer}) => {
      section.hidden = false;
      viewer?.show(viewer.mode in MAPS ? viewer.mode : 'side');
    });
  };
  onafterprint = () => {
    folds.forEach(fold => { fold.open = false; });
    scenes.forEach(({viewer}, i) => viewer?.show(modes[i]));
    current = showScene(scenes);
  };
}

async function start() {
  const scenes = JSON.parse(document.getElementById('data').textContent);
  document.querySelectorAll('img.plot').forEach(openPlot);
  makeTabs(scenes);
  listenToPage(scenes);
  if (!('DecompressionStream' in window))
    throw new Error('This browser cannot unpack the pictures. It lacks DecompressionStream, which ' +
      'Chrome and Edge have since version 80, Safari since 16.4 and Firefox since 113.');
  // The one that is looked at comes first.
  for (const scene of [...scenes].sort((a, b) => a.section.hidden - b.section.hidden)) await bringToLife(scene);
  document.body.classList.add('ready');
}

start().catch(error => {
  const trouble = document.getElementById('trouble');
  trouble.textContent = error.message;
  trouble.hidden = false;
});
