// SPDX-License-Identifier: Apache-2.0

// A scene file as a tree that can be edited and written again. Shapes are told by their numbers in
// the order of the file, which are the core's.

/** The reflectance of what is added. */
export const PLAIN = [0.73, 0.73, 0.73];

const text = number => String(Number(number.toPrecision(7)));
const list = vector => vector.map(text).join(', ');

export class SceneDocument {
  /** `xml` is a scene file that the core has read. */
  constructor(xml) {
    this.document = new DOMParser().parseFromString(xml, 'text/xml');
    this.root = this.document.documentElement;
  }

  xml() { return new XMLSerializer().serializeToString(this.document) + '\n'; }

  get sensor() { return this.root.querySelector('sensor'); }

  get shapes() { return [...this.root.querySelectorAll('shape')]; }

  /** The files that it names, without their folders. */
  get filenames() {
    const named = [...this.root.querySelectorAll('string[name=filename], include[filename], spectrum[filename]')];
    return named.map(node => (node.getAttribute('filename') ?? node.getAttribute('value')).split('/').at(-1));
  }

  // -- The camera

  look({origin, target, up, isMirrored}) {
    const mirror = isMirrored ? [this.make('scale', {x: '-1'})] : [];
    this.transformOf(this.sensor).replaceChildren(
      ...mirror, this.make('lookat', {origin: list(origin), target: list(target), up: list(up)}));
  }

  // -- Shapes

  /** What is added to a transform stands at its end: a scale and a translation, one each. */
  move(index, by) {
    const [, translation] = this.placeOf(index);
    for (const [axis, step] of ['x', 'y', 'z'].map((name, i) => [name, by[i]]))
      translation.setAttribute(axis, text(Number(translation.getAttribute(axis)) + step));
  }

  /** Scales by a factor about a point, which stays where it is. */
  scale(index, factor, about) {
    const [scale, translation] = this.placeOf(index);
    scale.setAttribute('value', text(Number(scale.getAttribute('value')) * factor));
    ['x', 'y', 'z'].forEach((axis, i) => {
      const before = Number(translation.getAttribute(axis));
      translation.setAttribute(axis, text(factor * before + (1 - factor) * about[i]));
    });
  }

  remove(index) {
    const shape = this.shapes[index], before = shape.previousSibling;
    if (before?.nodeType === Node.TEXT_NODE && before.data.trim() === '') before.remove();
    shape.remove();
  }

  /** Adds a sphere or an axis-aligned cuboid that fills a box, and returns its number. */
  add(kind, low, high) {
    const middle = low.map((a, i) => (a + high[i]) / 2), half = low.map((a, i) => (high[i] - a) / 2);
    const [x, y, z] = middle.map(text), [a, b, c] = half.map(text);
    const id = this.freeId(kind === 'cube' ? 'cuboid' : kind);
    const place = kind === 'sphere'
      ? [this.make('point', {name: 'center', x, y, z}), this.make('float', {name: 'radius', value: a})]
      : [this.make('transform', {name: 'to_world'}, this.make('scale', {x: a, y: b, z: c}),
        this.make('translate', {x, y, z}))];
    const shape = this.make('shape', {type: kind, id}, ...place, this.bsdf({material: 'matte', reflectance: PLAIN}));
    this.root.append(this.document.createTextNode('\n  '), shape, this.document.createTextNode('\n'));
    return this.shapes.indexOf(shape);
  }

  /** A shape's surface becomes another, of which all is told as the core tells it. */
  paint(index, surface) {
    const shape = this.shapes[index], one = this.bsdf(surface);
    const bsdf = surface.twoSided && surface.material !== 'glass' ? this.make('bsdf', {type: 'twosided'}, one) : one;
    const old = [...shape.children].filter(child => child.localName === 'bsdf' ||
      child.localName === 'ref' && this.byId(child.getAttribute('id'))?.localName === 'bsdf');
    if (old.length > 0) old[0].before(bsdf);
    else shape.append(bsdf);
    old.forEach(node => node.remove());
    // The core tells of a sphere as if its normals led outwards.
    if (shape.getAttribute('type') === 'sphere') this.parameter(shape, 'boolean', 'flip_normals', 'flipNormals')?.remove();
  }

  /** Of a lamp. */
  shine(index, radiance) {
    const shape = this.shapes[index], rgb = this.make('rgb', {name: 'radiance', value: list(radiance)});
    const emitters = [...shape.children].filter(child => child.localName === 'emitter' ||
      child.localName === 'ref' && this.byId(child.getAttribute('id'))?.localName === 'emitter');
    emitters.forEach(emitter => emitter.remove());
    shape.append(this.make('emitter', {type: 'area'}, rgb));
  }

  // -- Elements

  byId(id) { return [...this.root.querySelectorAll('[id]')].find(node => node.getAttribute('id') === id); }

  freeId(stem) {
    let number = 1;
    while (this.byId(`${stem}_${number}`)) number++;
    return `${stem}_${number}`;
  }

  make(tag, attributes, ...children) {
    const element = this.document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...children);
    return element;
  }

  bsdf({material, reflectance, eta, k, alpha, ior, transmittance}) {
    const rgb = (name, colour) => this.make('rgb', {name, value: list(colour)});
    const float = (name, number) => this.make('float', {name, value: text(number)});
    const gloss = rgb('specular_reflectance', reflectance);
    const string = (name, value) => this.make('string', {name, value});
    const smooth = () => ['conductor',
      ...[...eta, ...k].some(part => part > 0) ? [rgb('eta', eta), rgb('k', k)] : [string('material', 'none')], gloss];
    const makers = {
      matte: () => ['diffuse', rgb('reflectance', reflectance)],
      steel: smooth,
      metal: () => alpha > 0
        ? ['roughconductor', string('distribution', 'ggx'), float('alpha', alpha), ...smooth().slice(1)] : smooth(),
      glass: () => ['dielectric', float('int_ior', ior), float('ext_ior', 1), gloss,
        rgb('specular_transmittance', transmittance)],
    };
    const [type, ...parameters] = makers[material]();
    return this.make('bsdf', {type}, ...parameters);
  }

  parameter(node, tag, ...names) {
    return [...node.children].find(child => child.localName === tag && names.includes(child.getAttribute('name')));
  }

  transformOf(node) {
    const found = this.parameter(node, 'transform', 'to_world', 'toWorld');
    if (found) return found;
    const made = this.make('transform', {name: 'to_world'});
    node.prepend(made);
    return made;
  }

  placeOf(index) {
    const transform = this.transformOf(this.shapes[index]);
    const [last, before] = [...transform.children].reverse();
    const isOurs = before?.localName === 'scale' && before.hasAttribute('value') &&
      Number.isFinite(Number(before.getAttribute('value'))) && last.localName === 'translate' &&
      ['x', 'y', 'z'].every(axis => last.hasAttribute(axis) && Number.isFinite(Number(last.getAttribute(axis))));
    if (isOurs) return [before, last];
    const made = [this.make('scale', {value: '1'}), this.make('translate', {x: '0', y: '0', z: '0'})];
    transform.append(...made);
    return made;
  }
}
