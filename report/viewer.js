// SPDX-License-Identifier: Apache-2.0

'use strict';

// Two pictures side by side, in place of each other, split, or as a map of what differs.
const between = (value, low, high) => Math.min(Math.max(value, low), high);

class Viewer {
  constructor(form, pictures) {
    this.form = form;
    this.controls = form.elements;
    this.pictures = pictures;
    this.panes = [...form.querySelectorAll('canvas')];
    this.captions = [...form.querySelectorAll('figcaption')];
    this.map = document.createElement('canvas');
    this.zoom = 1;
    this.centre = [0.5, 0.5];  // of what is seen, in picture widths and heights
    this.showsB = false;
    this.pixel = [0.5, 0.5];  // what the read-out tells of, as a part of the picture
    for (const name of ['a', 'b'])
      this.controls[name].append(...pictures.map((picture, i) => new Option(picture.title, i)));
    this.controls.b.selectedIndex = Math.min(1, pictures.length - 1);
    this.listen();
    this.expose();
    this.choosePair();
    this.zoomBy(1);
  }

  get a() { return this.pictures[this.controls.a.value]; }
  get b() { return this.pictures[this.controls.b.value]; }
  get mode() { return this.controls.mode.value; }

  listen() {
    const {form} = this;
    form.onsubmit = event => event.preventDefault();
    form.oninput = ({target}) => {
      if (target.name === 'exposure') this.expose();
      if (target.name === 'scale') this.paintMap();
      this.draw();
    };
    form.onchange = ({target}) => {
      if (target.type === 'range') return;
      this.choosePair();
      this.draw();
    };
    form.onclick = ({target}) => { this.act(target.dataset.key); };
    this.panes.forEach(pane => this.listenToPane(pane));
    new ResizeObserver(() => this.draw()).observe(form);
  }

  listenToPane(pane) {
    let moves = null, last = null;
    pane.onwheel = event => {
      if (event.deltaY > 0 && this.zoom === 1) return;  // let the page scroll on
      event.preventDefault();
      this.zoomBy(2 ** (-between(event.deltaY, -200, 200) / 200), this.positionIn(pane, event));
      this.point(pane, event);
    };
    pane.onpointerdown = event => {
      pane.setPointerCapture(event.pointerId);
      last = this.positionIn(pane, event);
      const nearSplit = Math.abs(last[0] - this.controls.split.value) * pane.clientWidth < 16;
      moves = this.mode === 'split' && nearSplit ? 'split' : 'picture';
    };
    pane.onpointermove = event => {
      const now = this.positionIn(pane, event);
      if (moves === 'split') this.controls.split.value = now[0];
      if (moves === 'picture') this.pan(now[0] - last[0], now[1] - last[1]);
      last = now;
      this.point(pane, event);
    };
    pane.onpointerup = pane.onpointercancel = () => { moves = null; };
    pane.onpointerleave = () => { this.pointer = null; this.draw(); };
    pane.onkeydown = event => {
      const steps = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};
      if (!(event.key in steps) || this.zoom === 1) return;
      event.preventDefault();
      this.pan(...steps[event.key].map(step => step / 8));
      this.draw();
    };
  }

  /** Does what a key, or the button with that key, stands for; false if it is no key of ours. */
  act(key) {
    const exposeAt = stops => { this.controls.exposure.value = stops; this.expose(); };
    const stops = Number(this.controls.exposure.value);
    const acts = {
      'x': () => this.swap(), ' ': () => this.swap(), 'a': () => this.choosePair(),
      '[': () => exposeAt(stops - 0.5), ']': () => exposeAt(stops + 0.5), 'e': () => exposeAt(0),
      '+': () => this.zoomBy(2), '=': () => this.zoomBy(2), '-': () => this.zoomBy(0.5),
      '0': () => this.zoomBy(0),
    };
    this.controls.mode.forEach((mode, i) => { acts[i + 1] = () => this.show(mode.value); });
    if (!(key in acts)) return false;
    acts[key]();
    this.draw();
    return true;
  }

  choose(a, b) {
    this.controls.a.value = a;
    this.controls.b.value = b;
    this.show(this.mode);
    this.form.scrollIntoView();
  }

  show(mode) {
    this.controls.mode.value = mode;
    this.choosePair();
    this.draw();
  }

  swap() {
    if (this.mode === 'swap') this.showsB = !this.showsB;
    else this.show('swap');
  }

  expose() {
    const stops = Number(this.controls.exposure.value), tone = toneTable(stops);
    this.controls.stops.value = withMinus((stops > 0 ? '+' : '') + stops.toFixed(1)) + ' stops';
    this.pictures.forEach(picture => paintPicture(picture, tone));
  }

  /** Brings everything up to date that depends on the pair, the view or the channel. */
  choosePair() {
    const {a, b, mode, controls} = this;
    this.form.dataset.mode = mode;
    this.showsB = false;
    const trouble = mode in MAPS ? whyNoMap(mode, a, b) : '';
    this.form.querySelector('.message').textContent = trouble;
    this.form.classList.toggle('no-map', trouble !== '');
    this.values = mode in MAPS && !trouble ? MAPS[mode](a, b, controls.channel.value) : null;
    if (this.values) controls.scale.value = automaticStep(this.values, controls.scale);
    this.paintMap();
    // Kept for the read-out, whatever is shown.
    this.scores = ['z', 'block'].map(name => whyNoMap(name, a, b) ? null : MAPS[name](a, b));
    this.readOut();
  }

  paintMap() {
    Object.assign(this.map, {width: this.a.width, height: this.a.height});
    if (!this.values) return;
    const scale = scaleOf(Number(this.controls.scale.value));
    paintMap(this.map, this.values, scale);
    const unit = this.mode === 'difference' ? '' : ' sd';
    this.controls.range.value = `±${number(scale)}${unit}`;
    this.form.querySelector('.low').textContent = `−${number(scale)}${unit}: B brighter`;
    this.form.querySelector('.high').textContent = `A brighter: +${number(scale)}${unit}`;
  }

  // ---- what is seen ----

  positionIn(pane, event) {
    const box = pane.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  corner() { return this.centre.map(middle => middle - 0.5 / this.zoom); }

  zoomBy(factor, about = [0.5, 0.5]) {
    const before = this.zoom, corner = this.corner();
    this.zoom = between(before * factor, 1, MOST_ZOOM);
    const change = 1 / before - 1 / this.zoom;  // what is at `about` stays there
    this.look(corner.map((start, i) => start + about[i] * change + 0.5 / this.zoom));
  }

  pan(across, down) {
    this.look([this.centre[0] - across / this.zoom, this.centre[1] - down / this.zoom]);
  }

  look(centre) {
    const margin = 0.5 / this.zoom;
    this.centre = centre.map(middle => between(middle, margin, 1 - margin));
    this.controls.factor.value = `${Number(this.zoom.toPrecision(2))}×`;
    // A finger that drags a picture as large as its pane means to scroll the page.
    this.panes.forEach(pane => { pane.style.touchAction = this.zoom > 1 ? 'none' : 'pan-y'; });
  }

  point(pane, event) {
    const corner = this.corner();
    this.pointer = this.positionIn(pane, event).map((part, i) => corner[i] + part / this.zoom);
    this.pixel = this.pointer;
    this.readOut();
    this.draw();
  }

  readOut() {
    const {a, b} = this;
    const [x, y] = this.pixelIn(a);
    const valuesIn = picture => {
      const [column, row] = this.pixelIn(picture), i = row * picture.width + column;
      return ['R', 'G', 'B', 'mean'].map(channel => picture.planes[channel][i])
        .concat(picture.noise ? picture.noise[i] : null);
    };
    const inA = valuesIn(a), inB = valuesIn(b);
    const both = a.noise || b.noise ? Math.hypot(inA[4], inB[4]) : null;
    const lines = ['R', 'G', 'B', 'mean', 'noise'].map((name, i) => element('tr', {},
      element('th', {}, name),
      ...[number(inA[i]), number(inB[i]), i < 4 ? signed(inA[i] - inB[i]) : number(both)]
        .map(text => element('td', {}, text || 'not known'))));
    this.form.querySelector('.readout tbody').replaceChildren(...lines);
    const [z, block] = this.scores.map(scores =>
      scores ? signed(scores[y * a.width + x], 3) : 'not known');
    this.form.querySelector('.where').textContent = `x ${x}, y ${y} · z ${z} · z of the block ${block}`;
  }

  pixelIn(picture) {
    return [picture.width, picture.height].map((size, i) =>
      between(Math.floor(this.pixel[i] * size), 0, size - 1));
  }

  // ---- drawing ----

  draw() {
    const {a, b, mode} = this, shown = this.showsB ? b : a;
    const titles = {side: `A: ${a.title}`, swap: `${this.showsB ? 'B' : 'A'}: ${shown.title}`,
      split: `left A: ${a.title} · right B: ${b.title}`};
    this.captions[0].textContent = titles[mode] ?? `A − B: ${a.title} − ${b.title}`;
    this.captions[1].textContent = `B: ${b.title}`;
    this.drawPane(this.panes[0], mode in MAPS ? this.map : shown.canvas);
    this.drawPane(this.panes[1], b.canvas);
    if (mode === 'split') this.drawSplit(this.panes[0]);
    if (this.pointer) this.panes.forEach(pane => this.drawPointer(pane));
  }

  drawPane(pane, source) {
    const width = Math.round(pane.clientWidth * devicePixelRatio);
    if (!width) return;
    Object.assign(pane, {width, height: Math.round(width * this.a.height / this.a.width)});
    this.drawPart(pane, source, 0);
  }

  /** Draws what lies right of `start`, a part of the pane's width. */
  drawPart(pane, source, start) {
    const context = pane.getContext('2d'), [left, top] = this.corner(), seen = 1 / this.zoom;
    context.imageSmoothingEnabled = pane.width * this.zoom < source.width;
    context.drawImage(source, (left + start * seen) * source.width, top * source.height,
      (1 - start) * seen * source.width, seen * source.height,
      start * pane.width, 0, (1 - start) * pane.width, pane.height);
  }

  drawSplit(pane) {
    const at = Number(this.controls.split.value), context = pane.getContext('2d');
    if (at < 1) this.drawPart(pane, this.b.canvas, at);
    context.fillStyle = '#888';
    context.fillRect(at * pane.width - 1, 0, 2, pane.height);
    context.fillRect(at * pane.width - 4, pane.height / 2 - 16, 8, 32);
  }

  drawPointer(pane) {
    const context = pane.getContext('2d'), corner = this.corner(), [x, y] = this.pixelIn(this.a);
    const side = Math.round(Math.max(pane.width * this.zoom / this.a.width, 5));
    const middle = [(x + 0.5) / this.a.width, (y + 0.5) / this.a.height];
    const [left, top] = middle.map((part, i) =>
      Math.round((part - corner[i]) * this.zoom * [pane.width, pane.height][i] - side / 2) + 0.5);
    ['#000', '#fff'].forEach((colour, ring) => {
      context.strokeStyle = colour;
      context.strokeRect(left - 1 - ring, top - 1 - ring, side + 2 + 2 * ring, side + 2 + 2 * ring);
    });
  }
}
