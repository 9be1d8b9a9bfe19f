// SPDX-License-Identifier: Apache-2.0

// The lessons' live figures: each takes the place of a picture, and is drawn while it is in view.
// make_lessons.py says what is written in a lesson for one.
import {Core} from './core.js';
import {drawCurve} from './curve.js';
import {showPictures} from './display.js';
import {Renderer} from './renderer.js';
import {halved, noiseAgainst, trueError} from './statistics.js';
import {compileCore, radianceOf, startWorkers} from './stored.js';

const DRAWING = 100;   // milliseconds between two drawings
const ENOUGH = 65536;  // samples per pixel after which a figure rests
const SEED = 1;        // as `plumb render` has it
const USUAL = {method: 'mis', sampler: 'sobol', first: 0, last: null, fault: null, light: null, parameters: {}};

const percent = value => `${Number((100 * value).toPrecision(3))} %`;

function make(tag, properties, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

const labelled = (text, control) => make('label', {}, `${text} `, control);
const choiceOf = (names, value) => make('select', {}, ...names.map(name => new Option(name, name, name === value, name === value)));

class Figure {
  constructor(element, core, module, data) {
    this.element = element;
    this.live = JSON.parse(element.dataset.live);
    this.names = Object.keys(this.live.pictures);
    this.scene = data.scenes[this.live.scene];
    this.trouble = make('p', {className: 'trouble', hidden: true});
    element.append(this.trouble);
    this.faults = core.faults().map(([name]) => name);
    this.camera = core.load(this.scene.files, this.scene.name).camera;
    this.renderer = new Renderer(module, startWorkers(data.worker), (...told) => this.receive(...told),
      text => this.say(text));
  }

  // -- What is on the page

  build() {
    const {live, names} = this;
    this.canvas = make('canvas', {role: 'img', ariaLabel: this.element.querySelector('img').alt});
    this.frame = make('div', {className: names.length > 1 ? 'frame split' : 'frame'}, this.canvas);
    this.split = make('input', {type: 'range', min: 0, max: 1, step: 0.005, value: 0.5, oninput: () => this.draw()});
    this.sides = [choiceOf(names, names[0]), choiceOf(names, names[1])];
    this.exposure = make('input', {type: 'range', min: -4, max: 6, step: 0.25, value: live.exposure ?? 0,
      oninput: () => this.draw()});
    const {width, height} = this.camera, most = Math.max(width, height);
    this.size = make('select', {onchange: () => this.begin()}, ...[1, 2, 4].map(part =>
      new Option(`${width / part} × ${height / part}`, most / part, false, most / part === live.size)));
    this.pause = make('button', {type: 'button', textContent: 'Pause', onclick: () => this.halt(!this.isHalted)});
    this.controls = (live.controls ?? []).map(control => this.control(control));
    this.rows = make('table', {className: 'numbers'});
    this.curve = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    this.curve.setAttribute('role', 'img');
    this.curve.setAttribute('aria-label', 'Error against samples per pixel');
    for (const side of this.sides) side.onchange = () => this.draw();
    this.canvas.onpointerdown = event => this.moveSplit(event);
    this.canvas.onpointermove = event => event.buttons && this.moveSplit(event);

    const views = names.length === 1 ? [] : [
      labelled('Left', this.sides[0]), labelled('Right', this.sides[1]), labelled('Split', this.split)];
    this.element.append(make('div', {className: 'at-work'},
      make('div', {className: 'controls'}, ...this.controls.map(({label}) => label)),
      make('div', {className: 'stage'}, this.frame,
        make('div', {}, ...live.curve ? [this.curve, make('p', {className: 'quiet', textContent: this.about()})] : [],
          this.rows)),
      make('div', {className: 'controls'}, ...views, labelled('Exposure', this.exposure),
        labelled('Size', this.size), this.pause),
      ...live.caption ? [make('p', {className: 'quiet', textContent: live.caption})] : []));
  }

  about() {
    const what = this.live.curve === 'error' ? 'Error against the stored, converged picture'
      : 'Noise, as the pictures’ own scatter tells it';
    return `${what}, as samples per pixel grow. Dotted: 1/√N.`;
  }

  /** A slider or a choice; every value of it is a name and the settings that it stands for. */
  control({title, values, start, isSlider}) {
    const names = Object.keys(values), output = make('output', {textContent: start});
    const input = isSlider
      ? make('input', {type: 'range', min: 0, max: names.length - 1, step: 1, value: names.indexOf(start)})
      : choiceOf(names, start);
    const name = () => isSlider ? names[input.value] : input.value;
    input.oninput = () => {
      output.textContent = name();
      if (isSlider) input.setAttribute('aria-valuetext', name());
      this.begin();
    };
    return {label: make('label', {}, `${title} `, input, ...isSlider ? [output] : []), settings: () => values[name()]};
  }

  moveSplit({clientX}) {
    const {left, width} = this.canvas.getBoundingClientRect();
    this.split.value = (clientX - left) / width;
    this.draw();
  }

  say(text) {
    this.trouble.hidden = false;
    this.trouble.textContent = text;
  }

  // -- Drawing

  /** The settings of a picture: those of the controls go before its own, and both before the usual. */
  settingsOf(name) {
    const all = [this.live.settings, this.live.pictures[name], ...this.controls.map(({settings}) => settings())];
    return Object.assign({}, USUAL, ...all);
  }

  begin() {
    if (this.hasRested) this.halt(false);
    this.hasRested = false;
    const {files, name} = this.scene, {parameters} = this.settingsOf(this.names[0]);
    const xml = Object.entries(parameters).reduce((text, [parameter, value]) =>
      text.replace(new RegExp(`(<default name="${parameter}" value=")[^"]*`), `$1${value}`), files[name]);
    this.renderer.setScene({...files, [name]: xml}, name);
    this.pictures = [];
    this.curves = this.names.map(() => []);
    const scale = this.size.value / Math.max(this.camera.width, this.camera.height);
    const [width, height] = [this.camera.width * scale, this.camera.height * scale];
    this.reference = this.stored;
    for (let across = this.scene.picture?.width; this.reference && across > width; across /= 2)
      this.reference = halved(this.reference, across, across * height / width);
    this.names.forEach((picture, number) => {
      const {method, sampler, first, last, fault, light} = this.settingsOf(picture);
      this.renderer.begin(number, {width, height, method, sampler, seed: SEED,
        bounces: [first, last ?? Infinity], light, fault: fault === null ? -1 : this.faults.indexOf(fault)});
    });
  }

  /** The picture remains until there is something to be seen in its place. */
  async start() {
    this.stored = this.scene.picture ? await radianceOf(this.scene.picture) : null;
    this.build();
    this.begin();
  }

  /** Rests while nobody looks. */
  show(isInView) {
    this.isInView = isInView;
    this.renderer.pause(!isInView || this.isHalted);
  }

  halt(isHalted) {
    this.isHalted = isHalted;
    this.pause.textContent = isHalted ? 'Go on' : 'Pause';
    this.show(this.isInView);
  }

  receive(number, picture) {
    this.pictures[number] = picture;
    if (picture.samples >= ENOUGH && !this.hasRested) {
      this.hasRested = true;
      this.halt(true);
    }
    this.drawing ??= setTimeout(() => {
      this.drawing = null;
      this.draw();
    }, DRAWING);
  }

  draw() {
    const sides = this.sides.map(side => this.pictures[this.names.indexOf(side.value)]);
    if (this.pictures.filter(Boolean).length < this.names.length) return;
    const [left, right] = this.names.length > 1 ? sides : [sides[0], null];
    showPictures(this.canvas, left, right, right ? Number(this.split.value) : 1, Number(this.exposure.value));
    this.frame.style.setProperty('--split', `${100 * this.split.value}%`);
    this.element.classList.add('is-live');
    this.record();
    this.tell();
    this.element.dataset.samples = Math.min(...this.pictures.map(({samples}) => samples));
  }

  errorOf(picture) {
    if (picture.samples < 4) return null;
    if (this.live.curve === 'error') return trueError(picture, this.reference);
    // Noise is told in parts of what the least noisy picture shows: a noisy one knows little of that.
    const {samples, mean} = this.pictures[this.names.indexOf(this.live.against ?? this.names[0])];
    return samples < 16 ? null : noiseAgainst(picture, mean);
  }

  record() {
    this.pictures.forEach((picture, number) => {
      const curve = this.curves[number], last = curve.at(-1), error = this.errorOf(picture);
      if (error && (!last || picture.samples >= 1.1 * last[0])) curve.push([picture.samples, error]);
    });
    if (this.live.curve)
      drawCurve(this.curve, this.names.map((_, number) => ({name: `s${number}`, points: this.curves[number]})));
  }

  /** What part of the stored picture's light is in this one: red, green, blue. */
  shareOf({mean}) {
    const sum = (values, c) => values.reduce((all, value, i) => i % 3 === c ? all + value : all, 0);
    return [0, 1, 2].map(c => percent(sum(mean, c) / sum(this.reference, c)));
  }

  tell() {
    const error = this.live.curve === 'error' ? 'error' : 'noise';
    const head = ['', 'samples', error, ...this.live.share ? ['of all red', 'green', 'blue'] : []];
    const rows = this.pictures.map((picture, number) => {
      const value = this.errorOf(picture);
      return [this.names[number], picture.samples, value ? percent(value) : '…',
        ...this.live.share ? this.shareOf(picture) : []];
    });
    this.rows.replaceChildren(make('tr', {}, ...head.map(text => make('th', {textContent: text}))),
      ...rows.map((cells, number) => make('tr', {className: `s${number}`},
        ...cells.map(text => make('td', {textContent: text})))));
  }
}

async function start() {
  const data = globalThis.plumblineLessons, elements = [...document.querySelectorAll('.live')];
  if (elements.length === 0) return;
  const module = await compileCore(data.core), core = await Core.create(module), figures = new Map();
  const observer = new IntersectionObserver(entries => entries.forEach(({target, isIntersecting}) => {
    if (isIntersecting && !figures.has(target)) {
      figures.set(target, new Figure(target, core, module, data));
      const figure = figures.get(target);
      figure.start().catch(error => figure.say(error.message));
    }
    figures.get(target)?.show(isIntersecting);
  }));
  for (const element of elements) observer.observe(element);
}

// Where a figure can't be live, its picture remains.
start().catch(error => {
  document.querySelector('.live').append(make('p', {className: 'trouble', textContent: error.message}));
});

// Answers are read on paper, too.
let unfolded = [];
window.addEventListener('beforeprint', () => {
  unfolded = [...document.querySelectorAll('details:not([open])')];
  for (const answer of unfolded) answer.open = true;
});
window.addEventListener('afterprint', () => { for (const answer of unfolded) answer.open = false; });
