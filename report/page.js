// SPDX-License-Identifier: Apache-2.0

'use strict';

const VERDICTS = ['same', 'different', 'inconclusive'];
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
const percent = (bias, confidence) => typeof bias !== 'number' ? '' :
  withMinus((bias < 0 ? '' : '+') + (100 * bias).toFixed(3)) +
  (typeof confidence === 'number' ? ` ± ${(100 * confidence).toFixed(3)}` : '') + ' %';

const command = text => text ? element('pre', {className: 'command'}, text) : null;
const folded = (title, ...content) => element('details', {}, element('summary', {}, title), ...content);
const isNumber = text => /^[^a-z]*\d[^a-z]*(e[-−+]?\d+)?( ?%| s)?$/i.test(text);

/** A table; cells that are numbers are set flush right. */
function table(head, rows) {
  const kind = text => isNumber(text) ? 'number' : VERDICTS.includes(text) ? text : '';
  const cell = text => element('td', {className: kind(String(text))}, String(text));
  const body = rows.map(row => element('tr', {}, ...row.map(text => cell(text ?? ''))));
  const heads = head.map((text, i) =>
    element('th', {className: isNumber(String(rows[0]?.[i])) ? 'number' : ''}, text));
  return element('div', {className: 'wide'}, element('table', {},
    element('thead', {}, element('tr', {}, ...heads)), element('tbody', {}, ...body)));
}

/** Any JSON as names and values; lists and objects inside are folded away. */
function card(value) {
  const list = element('dl', {className: 'card'});
  for (const [name, entry] of Object.entries(value)) {
    const simple = Array.isArray(entry) && entry.every(one => one === null || typeof one !== 'object');
    if (entry !== null && typeof entry === 'object' && !simple) {
      const many = Array.isArray(entry), title = Array.isArray(value) ? String(+name + 1) : name;
      const fold = folded(many ? `${title} (${entry.length})` : title, card(entry));
      fold.classList.toggle('list', many);
      list.append(element('div', {className: 'nested'}, fold));
    } else
      list.append(element('dt', {}, name), element('dd', {}, simple ? entry.join(', ') : String(entry)));
  }
  return list;
}

function verdictRows(verdict, show) {
  const whole = verdict.rows.find(row => row.where === 'image' && row.channel === 'all') ?? {};
  const cells = [
    element('td', {}, verdict.test), element('td', {}, verdict.reference),
    element('td', {className: verdict.verdict}, verdict.verdict),
    element('td', {className: 'number'}, percent(whole.bias, whole.confidence)),
    element('td', {}, show ? element('button', {type: 'button', onclick: show}, 'View') : null)];
  const rows = verdict.rows.map(row => [row.where, row.channel, number(row.test),
    number(row.reference), percent(row.bias, row.confidence), row.verdict]);
  const heads = ['where', 'channel', 'test', 'reference', 'bias', 'verdict'];
  const more = element('td', {colSpan: cells.length},
    element('p', {className: 'explanation'}, verdict.explanation),
    folded('Regions and channels', table(heads, rows)), command(verdict.command));
  return element('tbody', {className: 'verdict'}, element('tr', {}, ...cells), element('tr', {}, more));
}

function verdictTable(scene, viewer) {
  const bodies = scene.verdicts.map(verdict => {
    const [a, b] = ['test', 'reference'].map(side =>
      scene.pictures.findIndex(picture => picture.title === verdict[side]));
    return verdictRows(verdict, a < 0 || b < 0 ? null : () => viewer.choose(a, b));
  });
  const heads = ['Test', 'Reference', 'Verdict', 'Bias of the whole', ''];
  return element('div', {className: 'wide'}, element('table', {className: 'verdicts'},
    element('thead', {}, element('tr', {}, ...heads.map(text => element('th', {}, text)))), ...bodies));
}

function plot(title, result) {
  if (!result) return [];
  // As an image of its own, because plots inlined side by side would share their ids.
  const image = result.svg ? element('img', {
    className: 'plot', alt: `${title}: ${result.sentences.join(' ')}`,
    src: 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(result.svg)}) : null;
  return [element('h3', {}, title), image,
    ...result.sentences.map(sentence => element('p', {}, sentence)),
    result.table?.rows.length ? table(result.table.head, result.table.rows) : null,
    command(result.command)];
}

const seconds = picture => typeof picture.seconds === 'number' ? `, ${number(picture.seconds)}\u00a0s` : '';
const thumbnail = picture => element('figure', {}, picture.canvas,
  element('figcaption', {}, picture.title + seconds(picture)));

function sceneSection(scene) {
  const section = document.getElementById('scene').content.cloneNode(true).firstElementChild;
  section.querySelector('h2').textContent = scene.title;
  section.querySelector('.pictures').append(...scene.pictures.map(thumbnail));
  const viewer = new Viewer(section.querySelector('.viewer'), scene.pictures);
  const results = element('div', {},
    scene.verdicts.length ? element('h3', {}, 'Verdicts') : null,
    scene.verdicts.length ? verdictTable(scene, viewer) : null,
    ...plot('Convergence', scene.convergence), ...plot('Speed against accuracy', scene.chart),
    element('h3', {}, 'How the pictures were made'),
    ...scene.pictures.map(picture =>
      folded(picture.title + seconds(picture), command(picture.command), card(picture.card ?? {}))));
  section.querySelector('.results').replaceWith(results);
  return {section, viewer, name: scene.name, title: scene.title};
}

// ---- The page ----------------------------------------------------------------------------------

function showScene(scenes) {
  const current = scenes.find(scene => `#${scene.name}` === decodeURIComponent(location.hash)) ?? scenes[0];
  for (const scene of scenes) {
    scene.section.hidden = scene !== current;
    scene.link.toggleAttribute('aria-current', scene === current);
  }
  current?.viewer.draw();
  return current;
}

function listenToPage(scenes) {
  let current = showScene(scenes), folds = [], modes = [];
  onhashchange = () => { current = showScene(scenes); };
  onkeydown = event => {
    const {target} = event, waits = event.key === ' ' && target.closest('button, summary, a');
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest('select') || waits) return;
    if (current?.viewer.act(event.key)) event.preventDefault();
  };
  // On paper there is nothing to click: all scenes, both pictures and all but long lists are seen.
  onbeforeprint = () => {
    folds = [...document.querySelectorAll('details:not([open])')].filter(fold => !fold.closest('.list'));
    folds.forEach(fold => { fold.open = true; });
    modes = scenes.map(({viewer}) => viewer.mode);
    scenes.forEach(({section, viewer}) => {
      section.hidden = false;
      viewer.show(viewer.mode in MAPS ? viewer.mode : 'side');
    });
  };
  onafterprint = () => {
    folds.forEach(fold => { fold.open = false; });
    scenes.forEach(({viewer}, i) => viewer.show(modes[i]));
    showScene(scenes);
  };
}

async function start() {
  const data = JSON.parse(document.getElementById('data').textContent);
  document.title = document.querySelector('h1').textContent = data.title;
  document.querySelector('.made').textContent = `Plumbline ${data.version} · ${data.made} · ${data.host}`;
  document.querySelector('.incomplete').textContent = data.incomplete;
  for (const list of ['summary', 'notes'])
    document.querySelector(`.${list}`).append(...data[list].map(text => element('li', {}, text)));
  if (!('DecompressionStream' in window))
    throw new Error('This browser cannot unpack the pictures. It lacks DecompressionStream, which ' +
      'Chrome and Edge have since version 80, Safari since 16.4 and Firefox since 113.');
  await Promise.all(data.scenes.flatMap(scene => scene.pictures).map(loadPicture));
  const scenes = data.scenes.map(sceneSection);
  scenes.forEach(scene => { scene.link = element('a', {href: `#${scene.name}`}, scene.title); });
  document.querySelector('nav').append(...scenes.map(scene => scene.link));
  document.querySelector('main').append(...scenes.map(scene => scene.section));
  listenToPage(scenes);
  document.body.classList.add('ready');
}

start().catch(error => {
  const trouble = document.getElementById('trouble');
  trouble.textContent = error.message;
  trouble.hidden = false;
});
