// SPDX-License-Identifier: Apache-2.0

// The live page: its controls, and what they do to scene and pictures.
import {srgb} from '../report/pictures.js';
import {lookAt, orbit, pan, upAxisOf, zoom} from './camera.js';
import {Core, CoreError, MOST_BOUNCES} from './core.js';
import {drawCurve} from './curve.js';
import {FULL_COLOUR, showDifference, showOverlay, showPictures} from './display.js';
import {EFFECTS} from './effects.js';
import {listen} from './gestures.js';
import {fragmentOf, sceneOf} from './link.js';
import {Renderer} from './renderer.js';
import {PLAIN, SceneDocument} from './scene_document.js';
import {claimedError, halved, trueError} from './statistics.js';
import {compileCore, radianceOf, startWorkers} from './stored.js';
import {add, dot, normalize, subtract, times} from './vectors.js';

const REST = 200;     // milliseconds after the last movement until the picture has its full size
const DRAWING = 50;   // milliseconds between two drawings
const SEED = 1;       // as `plumb render` has it
const SIZES = [128, 256, 512];
const SIDES = ['A', 'B'];

const find = selector => document.querySelector(selector);
const percent = value => `${Number((100 * value).toPrecision(3))} %`;

/** sRGB as in <input type=color>, from and to linear RGB. */
const toLinear = hex => [1, 3, 5].map(i => {
  const code = parseInt(hex.slice(i, i + 2), 16) / 255;
  return code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;
});
const toHex = rgb => '#' + rgb.map(light => Math.round(srgb(light)).toString(16).padStart(2, '0')).join('');

const boxOf = boxes => {
  const bound = (pick, name) => [0, 1, 2].map(i => pick(...boxes.map(box => box[name][i])));
  return {low: bound(Math.min, 'low'), high: bound(Math.max, 'high')};
};

/** What the colour of a thing is. */
const colourOf = ({material}) => material === 'glass' ? 'transmittance' : 'reflectance';

/** A surface of another material, which keeps its colour, but of glass: that is clear at first. */
function madeOf(material, {material: before, reflectance, twoSided}) {
  const colour = material === 'glass' ? [1, 1, 1] : before === 'glass' ? PLAIN : reflectance;
  const nothing = [0, 0, 0];
  return {material, reflectance: colour, eta: nothing, k: nothing, alpha: 0, ior: 1.5, transmittance: [1, 1, 1], twoSided};
}

class Page {
  constructor(core, renderer, scenes) {
    Object.assign(this, {core, renderer, scenes});
    this.panel = find('#panel').elements;
    this.pictures = [null, null];
    this.curves = [[], []];
    this.references = {};
    this.selected = -1;
    this.effect = null;  // that is looked at
    renderer.onPicture = (number, picture) => this.receive(number, picture);
    renderer.onTrouble = text => this.say(text, true);
    this.fillControls();
    this.listen();
  }

  // -- Scenes

  /** `scene` is {base, name, files, xml}: what is built in, or where from else; xml if it is edited. */
  async open(scene) {
    const builtIn = this.scenes[scene.base];
    const files = {...builtIn?.files, ...scene.files}, name = scene.name ?? 'scene.xml';
    const xml = scene.xml ?? files[name];
    const before = this.scene;
    cancelAnimationFrame(this.frame);
    clearTimeout(this.resting);
    this.frame = null;
    this.scene = {base: scene.base, name, files, own: scene.files ?? {}, original: builtIn?.files[name] ?? null};
    if (!this.apply(xml)) {
      this.scene = before;
      return false;
    }
    this.past = [xml];
    this.now = 0;
    this.upAxis = upAxisOf(this.camera);
    this.select(-1);
    this.chooseEffect(null);
    this.setBounces(this.description.bounces);
    this.curves = [[], []];
    const title = builtIn?.title ?? name;
    const choices = this.panel.scene;
    if (!builtIn && ![...choices.options].some(option => option.value === '')) choices.append(new Option('', ''));
    if (!builtIn) [...choices.options].find(option => option.value === '').text = title;
    choices.value = builtIn ? scene.base : '';
    find('#effects').hidden = scene.base !== 'seed';
    this.references = {};
    this.settle();
    await this.loadReferences();
    return true;
  }

  get isEdited() { return this.xml !== this.scene.original; }

  async loadReferences() {
    const {scene} = this, references = {};
    for (const [word, picture] of Object.entries(this.scenes[scene.base]?.pictures ?? {}))
      references[word] = {...picture, values: await radianceOf(picture)};
    if (this.scene !== scene) return;
    this.references = references;
    this.curves = [[], []];  // of errors against the reference from now on
    this.fillShow();
  }

  /** Reads the scene anew; after a refusal says why, and all is as before. */
  apply(xml) {
    try {
      this.description = this.core.load({...this.scene.files, [this.scene.name]: xml}, this.scene.name);
    } catch (error) {
      if (!(error instanceof CoreError)) throw error;
      this.say(error.message, true);
      if (this.xml) this.document = new SceneDocument(this.xml);
      return false;
    }
    this.say(this.description.notes.join('\n'), false);
    this.xml = xml;
    this.document = new SceneDocument(xml);
    this.renderer.setScene({...this.scene.files, [this.scene.name]: xml}, this.scene.name);
    const {shapes, camera} = this.description;
    this.canEdit = this.document.shapes.length === shapes.length;
    this.camera = camera;
    if (this.selected >= shapes.length) this.selected = -1;
    return true;
  }

  /** Changes shapes of the document. */
  edit(edit, isMoving = false) {
    if (this.canEdit) return this.change(edit, isMoving);
    return this.say('Shapes that stand in included files can’t be changed here.', true);
  }

  /** Changes the document by `edit`, at most once per frame while something moves. */
  change(edit, isMoving) {
    edit(this.document);
    if (!isMoving) {
      if (this.apply(this.document.xml())) this.settle();
      return undefined;
    }
    this.isMoving = true;
    this.frame ??= requestAnimationFrame(() => {
      this.frame = null;
      if (this.apply(this.document.xml())) this.begin();
      this.fillThing();
    });
    return undefined;
  }

  /** Draws in full size, and keeps the scene as it is for undoing and in the address. */
  settle() {
    if (this.frame) {
      cancelAnimationFrame(this.frame);
      this.frame = null;
      this.apply(this.document.xml());
    }
    this.isMoving = false;
    if (this.past[this.now] !== this.xml) {
      this.past.splice(++this.now, Infinity, this.xml);
      if (this.effectXml !== this.xml) this.chooseEffect(null);
    }
    this.panel.undo.disabled = this.now === 0;
    this.panel.redo.disabled = this.now === this.past.length - 1;
    this.fillSelected();
    this.fillOrigins();
    this.tellWords();
    this.fillShow();
    this.begin();
    this.updateAddress();
  }

  async updateAddress() {
    const {scene: {base, name, own}, xml} = this;
    const fragment = this.isEdited ? await fragmentOf({base, name, files: own, xml}) : `#${base}`;
    if (xml === this.xml && location.hash !== fragment) history.replaceState(null, '', fragment);
  }

  step(by) {
    if (this.isMoving) this.settle();
    const xml = this.past[this.now + by];
    if (xml === undefined) return;
    this.now += by;
    this.select(-1);
    this.chooseEffect(null);
    this.apply(xml);
    this.settle();
  }

  async openFiles(list) {
    const files = {};
    for (const file of list) {
      files[file.name] = file.name.endsWith('.ply') ? new Uint8Array(await file.arrayBuffer()) : await file.text();
    }
    const name = Object.keys(files).find(file => file.endsWith('.xml'));
    if (!name) return this.say('There is no scene file (.xml) among them.', true);
    return this.open({base: null, name, files});
  }

  save() {
    const offer = (name, text) => {
      const link = document.createElement('a');
      link.href = URL.createObjectURL(new Blob([text], {type: 'application/octet-stream'}));
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    };
    const others = [...new Set(this.document.filenames)].filter(name => name in this.scene.files);
    offer(this.scene.name, this.xml);
    for (const name of others) offer(name, this.scene.files[name]);
    this.say(`Saved ${[this.scene.name, ...others].join(', ')}: plumb render and Mitsuba 3 read it, with the other files ` +
      'where it names them. They show the backs of walls, through which this page looks.', false);
  }

  // -- Pictures

  settingsOf(side) {
    const {width, height} = this.description.camera;
    const controls = this.controls[side], part = this.isMoving ? 2 : 1;
    const scale = this.panel.pixels.value / Math.max(width, height) / part;
    const [first, last] = [controls.first, controls.last].map(input => input.value);
    return {
      width: Math.max(8, Math.round(width * scale)), height: Math.max(8, Math.round(height * scale)),
      method: controls.method.value, sampler: controls.sampler.value, seed: SEED,
      bounces: [Number(first) || 0, last === '' ? Infinity : Number(last)], fault: Number(controls.fault.value),
      light: controls.way.value ? {way: controls.way.value, ids: [controls.origin.value]} : null,
    };
  }

  begin() {
    SIDES.forEach((side, number) => {
      if (number === 0 || this.panel.compare.checked) {
        if (!this.isMoving) this.curves[number] = [];
        this.renderer.begin(number, this.settingsOf(side));
      } else {
        this.renderer.end(number);
        this.pictures[number] = null;
        this.curves[number] = [];
      }
    });
    document.body.dataset.samples = 0;
  }

  receive(number, picture) {
    this.pictures[number] = picture;
    this.drawing ??= setTimeout(() => {
      this.drawing = null;
      this.draw();
    }, Math.max(0, (this.drawn ?? 0) + DRAWING - performance.now()));
  }

  /** The reference for a picture, if there is one. */
  referenceFor({settings}) {
    const reference = this.references.plumbline;
    const fits = reference && !this.isEdited && settings.width === reference.width && !settings.light;
    return fits && settings.bounces[0] === 0 && settings.bounces[1] === Infinity ? reference.values : null;
  }

  record(number) {
    const picture = this.pictures[number];
    if (!picture || picture.samples < 4) return null;
    const reference = this.referenceFor(picture);
    const errors = {claimed: claimedError(picture), true: reference && trueError(picture, reference)};
    const curve = this.curves[number], last = curve.at(-1);
    const error = errors.true ?? errors.claimed;
    const isCurrent = this.renderer.pictures.get(number) === picture;
    if (isCurrent && !this.isMoving && error > 0 && (!last || picture.samples >= 1.1 * last[0]))
      curve.push([picture.samples, error]);
    return errors;
  }

  draw() {
    this.drawn = performance.now();
    const [a, b] = this.pictures, canvas = find('#picture');
    if (!a) return;
    const compares = this.panel.compare.checked && b?.settings.width === a.settings.width;
    const split = compares ? Number(find('#split').value) : null;
    const reference = this.references[this.panel.show.value];
    const {width, height} = a.settings;
    const isDifference = reference && !this.isEdited && width === this.references.plumbline.width;
    if (isDifference) {
      const halves = reference.width < width;
      showDifference(canvas, reference.width, reference.height, halves ? halved(a.mean, width, height) : a.mean,
        reference.values);
    } else {
      showPictures(canvas, a, compares ? b : null, split ?? 1, Number(this.panel.exposure.value));
    }
    find('.split').hidden = split === null || isDifference;
    const legend = find('.legend');
    legend.hidden = !reference;
    if (reference && !isDifference && !this.isMoving) {
      legend.textContent = `The stored pictures have ${this.references.plumbline.width} pixels: choose that size to subtract them.`;
    }
    if (isDifference) {
      legend.textContent = `Red where this picture is brighter than ${reference.title}, blue where it is darker; in full ` +
        `colour from ${percent(FULL_COLOUR)} on${reference.width < width ? '. Means of 2 × 2 pixels' : ''}.`;
    }
    this.drawOverlay(isDifference ? null : split);
    this.tellNumbers(SIDES.map((_, number) => this.record(number)));
    // Of the picture as it was begun last, not of one that still stands there.
    if (this.renderer.pictures.get(0) === a) document.body.dataset.samples = a.samples;
  }

  drawOverlay(split) {
    showOverlay(find('#overlay'),
      {camera: this.camera, box: this.description.shapes[this.selected], split});
  }

  tellNumbers(errors) {
    const rows = this.pictures.flatMap((picture, number) => {
      if (!picture || number === 1 && !this.panel.compare.checked) return [];
      const {samples, seconds, settings: {width, height}} = picture;
      const of = this.panel.compare.checked ? `${SIDES[number]}: ` : '';
      const pace = seconds > 0 ? samples * width * height / seconds / 1e6 : 0;
      const told = errors[number];
      return [[`${of}samples per pixel`, samples], [`${of}seconds`, seconds.toFixed(1)],
        [`${of}million samples a second`, pace.toFixed(2)],
        [`${of}noise, as it claims`, told ? percent(told.claimed) : '…'],
        ...told?.true ? [[`${of}error against the converged picture`, percent(told.true)]] : []];
    });
    const term = (tag, text) => Object.assign(document.createElement(tag), {textContent: text});
    find('.numbers').replaceChildren(...rows.map(([name, value]) => {
      const row = document.createElement('div');
      row.append(term('dt', name), term('dd', value));
      return row;
    }));
    const isTrue = errors.map(one => Boolean(one?.true));
    drawCurve(find('#curve'), SIDES.map((side, i) => ({name: side, points: this.curves[i], isClaimed: !isTrue[i]})));
    const what = isTrue[0] ? 'Error against the converged picture of this scene'
      : 'Noise as the picture claims it: how far it is from a converged one, if nothing is wrong';
    find('.curve figcaption').textContent = `${what}, as samples grow. Dotted: 1/√N, as independent samples fall.` +
      (this.panel.compare.checked ? ' Blue: A; orange: B.' : '');
  }

  // -- Moving

  get pivot() {
    const box = this.description.shapes[this.selected];
    if (box) return times(add(box.low, box.high), 0.5);
    const whole = boxOf(this.description.shapes), middle = times(add(whole.low, whole.high), 0.5);
    return middle.every(Number.isFinite) ? middle : add(this.camera.origin, this.camera.forward);
  }

  move(camera) {
    if (!this.document.sensor) return this.say('The camera stands in an included file and can’t be moved here.', true);
    const pivot = this.pivot;
    this.camera = camera;
    this.change(scene => scene.look(lookAt(camera, pivot)), true);
    return this.rest();
  }

  rest() {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.settle(), REST);
  }

  /** Whether a thing moves when it is dragged, and doesn't take the view with it: not a room's wall. */
  isMovable(index) {
    const {shapes} = this.description, {faces, radiance, low, high} = shapes[index];
    const box = boxOf(shapes), whole = subtract(box.high, box.low);
    const spans = subtract(high, low).filter((size, i) => size > 0.9 * whole[i] && whole[i] > 0).length;
    return radiance.some(light => light > 0) || faces === 0 || faces > 2 || spans < 2;
  }

  press(x, y) {
    const hit = this.core.pick(x, y);
    if (!hit || !this.canEdit || !this.isMovable(hit.shape)) return false;
    this.select(hit.shape);
    this.grabbed = {shape: hit.shape, point: hit.point};
    return true;
  }

  /** Along the floor, or with shift along a wall before the camera; steps in parts of the width. */
  drag(dx, dy, isUpright) {
    const {camera, grabbed: {shape, point}, upAxis} = this;
    const level = vector => normalize(vector.map((part, i) => i === upAxis ? 0 : part));
    const width = 2 * camera.halfWidth * dot(subtract(point, camera.origin), camera.forward);
    const up = [0, 1, 2].map(i => i === upAxis ? Math.sign(camera.up[i]) : 0);
    // Seen from the side, the floor is short; a thing that kept below the pointer would fly away.
    const slope = Math.max(Math.abs(camera.forward[upAxis]), 0.35);
    const other = isUpright ? up : times(level(camera.forward), 1 / slope);
    const step = this.within(shape, add(times(level(camera.right), dx * width), times(other, -dy * width)));
    this.grabbed.point = add(point, step);
    this.edit(scene => scene.move(shape, step), true);
  }

  /** A step of a thing, cut where it would leave the room in which it is. */
  within(shape, step) {
    const {low, high} = this.description.shapes[shape], room = this.room;
    if (!room) return step;
    return step.map((part, i) => {
      const isInside = low[i] >= room.low[i] && high[i] <= room.high[i];
      return isInside ? Math.max(room.low[i] - low[i], Math.min(part, room.high[i] - high[i])) : part;
    });
  }

  /** The box around what does not move, if there is such. */
  get room() {
    const walls = this.description.shapes.filter((_, i) => !this.isMovable(i));
    return walls.length > 0 ? boxOf(walls) : null;
  }

  // -- Things

  select(index) {
    this.selected = index;
    this.fillSelected();
    this.drawOverlay(this.panel.compare.checked ? Number(find('#split').value) : null);
  }

  addThing(kind) {
    const {low, high} = this.room ?? boxOf(this.description.shapes);
    const middle = times(add(low, high), 0.5), size = 0.12 * Math.min(...subtract(high, low).filter(side => side > 0));
    const isUp = this.camera.up[this.upAxis] > 0;
    // On the floor, in the middle.
    middle[this.upAxis] = isUp ? low[this.upAxis] + size : high[this.upAxis] - size;
    const half = [size, size, size];
    let index;
    this.edit(scene => { index = scene.add(kind, subtract(middle, half), add(middle, half)); });
    if (index !== undefined) this.select(index);
  }

  resize(factor) {
    const {low, high, faces} = this.description.shapes[this.selected];
    const about = times(add(low, high), 0.5);
    // What stands stays on its floor.
    if (faces !== 1) about[this.upAxis] = (this.camera.up[this.upAxis] > 0 ? low : high)[this.upAxis];
    this.edit(scene => scene.scale(this.selected, factor, about));
  }

  changeThing(name) {
    const {panel, selected} = this, shape = this.description.shapes[selected];
    const middle = times(add(shape.low, shape.high), 0.5), axis = 'xyz'.indexOf(name);
    const value = Number(panel[name]?.value);
    if (axis >= 0 && panel[name].value !== '') {
      this.edit(scene => scene.move(selected, middle.map((part, i) => i === axis ? value - part : 0)));
    } else if (name === 'size' && value > 0) {
      this.resize(value / this.sizeOf(shape));
    } else if (name === 'brightness' && value >= 0) {
      const most = Math.max(...shape.radiance);
      this.edit(scene => scene.shine(selected, shape.radiance.map(light => light / most * value)));
    } else if (name === 'colour') {
      this.edit(scene => scene.paint(selected, {...shape, [colourOf(shape)]: toLinear(panel.colour.value)}));
    } else if (name === 'material') {
      this.edit(scene => scene.paint(selected, madeOf(panel.material.value, shape)));
    } else if (name === 'ior' && value > 0) {
      this.edit(scene => scene.paint(selected, {...shape, ior: value}));
    }
    this.fillThing();
  }

  sizeOf({low, high}) { return Math.max(...subtract(high, low)); }

  remove() {
    if (this.selected < 0) return;
    const index = this.selected;
    this.selected = -1;
    this.edit(scene => scene.remove(index));
  }

  // -- Effects

  chooseEffect(effect) {
    if (effect || this.effect) this.setBounces([0, Infinity]);
    this.effect = effect;
    const without = this.panel.without;
    without.checked = false;
    without.closest('label').hidden = !effect;
    find('.told').textContent = effect ? effect.text : '';
    for (const button of find('#effects .buttons').children)
      button.setAttribute('aria-pressed', String(effect !== null && button.textContent === effect.title));
  }

  /** In the scene as it was before all edits, which undoing brings back. */
  lookAtEffect(effect) {
    if (this.isMoving) this.settle();
    const scene = new SceneDocument(this.scene.original);
    scene.look(effect.look);
    this.effectXml = scene.xml();
    if (!this.apply(this.effectXml)) return;
    this.chooseEffect(effect);
    this.settle();
  }

  setBounces([first, last]) {
    const {A} = this.controls;
    A.first.value = first;
    A.last.value = last >= MOST_BOUNCES ? '' : last;
  }

  // -- Controls

  fillControls() {
    const {panel} = this, faults = this.core.faults();
    for (const [word, {title}] of Object.entries(this.scenes)) panel.scene.append(new Option(title, word));
    for (const size of SIZES) panel.pixels.append(new Option(`${size} pixels`, size, size === 256, size === 256));
    this.controls = {};
    // Those of the demo first: what this project began with.
    const order = faults.map(([name, text], i) => ({name, text, i}))
      .sort((a, b) => b.name.startsWith('webgl') - a.name.startsWith('webgl'));
    for (const fieldset of document.querySelectorAll('.settings')) {
      fieldset.append(find('#settings').content.cloneNode(true));
      const controls = Object.fromEntries([...fieldset.querySelectorAll('[name]')].map(input => [input.name, input]));
      for (const {name, text, i} of order) controls.fault.append(new Option(`${name}: ${text}`, i));
      this.controls[fieldset.dataset.of] = controls;
    }
    find('#effects .buttons').append(...EFFECTS.map(effect => Object.assign(document.createElement('button'), {
      type: 'button', textContent: effect.title, onclick: () => this.lookAtEffect(effect)})));
    this.tellStops();
  }

  fillShow() {
    const {show} = this.panel, before = show.value, canCompare = !this.isEdited;
    show.replaceChildren(new Option('the picture', 'picture'), ...Object.entries(canCompare ? this.references : {})
      .map(([word, {title}]) => new Option(`the difference to ${title}`, word)));
    show.value = [...show.options].some(option => option.value === before) ? before : 'picture';
  }

  fillSelected() {
    const {selected} = this.panel;
    selected.replaceChildren(new Option('nothing', -1),
      ...this.description.shapes.map(({id}, i) => new Option(id || `shape ${i + 1}`, i)));
    selected.value = this.selected;
    this.fillThing();
  }

  /** A shape that is still there remains chosen. */
  fillOrigins() {
    for (const {origin} of Object.values(this.controls)) {
      const before = origin.value, ids = this.description.shapes.map(({id}) => id);
      origin.replaceChildren(...ids.map(id => new Option(id, id, false, id === before)));
    }
  }

  fillThing() {
    const shape = this.description.shapes[this.selected], {panel} = this;
    find('.thing').hidden = !shape;
    if (!shape) return;
    const isLamp = shape.radiance.some(light => light > 0);
    find('.thing .lamp').hidden = !isLamp;
    find('.thing .metal').hidden = shape.material !== 'metal';
    find('.thing .glass').hidden = shape.material !== 'glass';
    panel.material.value = shape.material;
    panel.colour.value = toHex(shape[colourOf(shape)]);
    const round = value => Number(value.toPrecision(5));
    const values = {size: this.sizeOf(shape), ior: shape.ior, brightness: Math.max(...shape.radiance)};
    times(add(shape.low, shape.high), 0.5).forEach((value, i) => { values['xyz'[i]] = value; });
    for (const [name, value] of Object.entries(values))
      if (document.activeElement !== panel[name]) panel[name].value = round(value);
  }

  tellStops() {
    const stops = Number(this.panel.exposure.value);
    this.panel.stops.value = `${stops > 0 ? '+' : ''}${stops} stops`.replace('-', '−');
  }

  /** The command's words for what is drawn that is not the scene's usual picture. */
  tellWords() {
    for (const {fault, way, origin} of Object.values(this.controls)) {
      const words = [way.value && `--${way.value} ${origin.value}`,
        fault.value !== '-1' && `--fault ${fault.selectedOptions[0].text.split(':')[0]}`].filter(Boolean);
      origin.closest('label').hidden = !way.value;
      fault.closest('fieldset').querySelector('.words').textContent = words.length ? `plumb render … ${words.join(' ')}` : '';
    }
  }

  say(text, isTrouble) {
    const trouble = find('#trouble');
    trouble.hidden = !isTrouble;
    trouble.textContent = isTrouble ? text : '';
    if (!isTrouble) find('#said').textContent = text;
  }

  listen() {
    const {panel} = this, form = find('#panel');
    form.onsubmit = event => event.preventDefault();
    const buttons = {
      undo: () => this.step(-1), redo: () => this.step(1), save: () => this.save(), remove: () => this.remove(),
      sphere: () => this.addThing('sphere'), cube: () => this.addThing('cube'), link: () => this.copyLink(),
      pause: () => {
        this.isPaused = !this.isPaused;
        panel.pause.setAttribute('aria-pressed', String(this.isPaused));
        panel.pause.textContent = this.isPaused ? 'Go on' : 'Pause';
        this.renderer.pause(this.isPaused);
      },
    };
    form.onclick = ({target}) => { if (target.type === 'button') buttons[target.name]?.(); };
    form.oninput = ({target}) => {
      if (target.name !== 'exposure') return;
      this.tellStops();
      this.draw();
    };
    form.onchange = ({target}) => this.changeControl(target);
    find('#split').oninput = () => this.draw();
    document.onkeydown = event => {
      const isTyping = event.target.matches('input[type=number], select');
      const key = event.ctrlKey || event.metaKey ? `ctrl ${event.key}` : event.key;
      const acts = {'ctrl z': () => this.step(-1), 'ctrl y': () => this.step(1), 'ctrl Z': () => this.step(1),
        Delete: () => this.remove(), Escape: () => this.select(-1)};
      if (isTyping || !(key in acts)) return;
      event.preventDefault();
      acts[key]();
    };
    const isFile = event => event.dataTransfer?.types.includes('Files');
    document.ondragover = event => { if (isFile(event)) event.preventDefault(); };
    document.ondrop = event => {
      if (!isFile(event)) return;
      event.preventDefault();
      this.openFiles(event.dataTransfer.files).catch(error => this.say(error.message, true));
    };
    document.onvisibilitychange = () => this.renderer.pause(document.hidden || Boolean(this.isPaused));
    window.onhashchange = () => this.openAddress();
    new ResizeObserver(() => this.draw()).observe(find('#picture'));
    listen(find('#picture'), {
      press: (x, y) => this.press(x, y), drag: (dx, dy, isUpright) => this.drag(dx, dy, isUpright),
      orbit: (dx, dy) => this.move(orbit(this.camera, this.pivot, -dx * 3, -dy * 3, this.upAxis)),
      pan: (dx, dy) => this.move(pan(this.camera, this.pivot, -dx, dy)),
      zoom: factor => this.move(zoom(this.camera, this.pivot, factor)),
      select: (x, y) => this.select(this.core.pick(x, y)?.shape ?? -1), end: () => this.isMoving && this.rest(),
    });
  }

  changeControl(input) {
    const side = input.closest('.settings')?.dataset.of;
    if (input.name === 'scene' && input.value) this.open({base: input.value});
    else if (input.name === 'open') this.openInput(input);
    else if (input.name === 'selected') this.select(Number(input.value));
    else if (input.closest('.thing')) this.changeThing(input.name);
    else if (side || ['compare', 'pixels', 'without'].includes(input.name)) this.changeSettings(input);
    else this.draw();
  }

  async openInput(input) {
    try {
      await this.openFiles(input.files);
    } catch (error) {
      this.say(error.message, true);
    }
    input.value = '';  // so that the same file can be chosen again
  }

  changeSettings(input) {
    find('.settings[data-of=B]').hidden = !this.panel.compare.checked;
    if (input.name === 'without') this.setBounces(input.checked ? this.effect.without : [0, Infinity]);
    this.tellWords();
    this.begin();
  }

  async copyLink() {
    try {
      await this.updateAddress();
      await navigator.clipboard.writeText(location.href);
      this.say('The link is copied. It holds the scene as it is now.', false);
    } catch {
      this.say('The address of this page holds the scene as it is now: copy it from there.', false);
    }
  }

  async openAddress() {
    const word = location.hash.slice(1);
    try {
      const scene = word in this.scenes ? {base: word} : await sceneOf(location.hash);
      if (scene && await this.open(scene)) return;
    } catch (error) {
      this.say(`The scene in this address is damaged: ${error.message}`, true);
    }
    // Is still to be read beside the scene that is opened instead.
    const trouble = find('#trouble').textContent;
    if (!this.scene) await this.open({base: Object.keys(this.scenes)[0]});
    if (trouble) this.say(trouble, true);
  }
}

async function start() {
  const data = JSON.parse(find('#data').textContent);
  const module = await compileCore(data.core);
  const renderer = new Renderer(module, startWorkers(find('#worker').textContent));
  const page = new Page(await Core.create(module), renderer, data.scenes);
  await page.openAddress();
}

start().catch(error => {
  const trouble = find('#trouble');
  trouble.hidden = false;
  trouble.textContent = error.message;
});
