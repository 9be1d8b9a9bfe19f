// SPDX-License-Identifier: Apache-2.0

// Error against samples per pixel, both on logarithmic scales, as an SVG.
const WIDTH = 360, HEIGHT = 220, LEFT = 46, RIGHT = 10, TOP = 10, BOTTOM = 34;
const NAMESPACE = 'http://www.w3.org/2000/svg';

function draw(parent, tag, attributes, text = '') {
  const node = document.createElementNS(NAMESPACE, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.textContent = text;
  parent.append(node);
}

/** Of 1, 2, 5, 10, ..., or of the powers of a base alone, those from `low` to `high`. */
function ticks(low, high, steps, base) {
  const first = Math.floor(Math.log(low) / Math.log(base)), last = Math.ceil(Math.log(high) / Math.log(base));
  const all = Array.from({length: last - first + 1}, (_, i) => steps.map(step => step * base ** (first + i))).flat();
  return all.filter(tick => tick >= low && tick <= high * (1 + 1e-9));
}

const percent = value => `${Number((100 * value).toPrecision(2))} %`;

/** Each series is {name, points: [samples, error][], isClaimed}; the first one's 1/sqrt(N) is drawn. */
export function drawCurve(svg, all) {
  const series = all.filter(({points}) => points.length > 0);
  svg.replaceChildren();
  svg.setAttribute('viewBox', `0 0 ${WIDTH} ${HEIGHT}`);
  if (series.length === 0) return;
  const points = series.flatMap(one => one.points);
  const errors = points.map(([, error]) => error);
  const most = Math.max(16, ...points.map(([samples]) => samples));
  const low = Math.min(...errors) / 1.3, high = Math.max(...errors) * 1.3;
  const scale = (value, from, to) => Math.log(value / from) / Math.log(to / from);
  const x = samples => LEFT + (WIDTH - LEFT - RIGHT) * scale(samples, 1, most);
  const y = error => HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * scale(error, low, high);
  for (const samples of ticks(1, most, [1], most > 2000 ? 8 : 4)) {
    draw(svg, 'line', {class: 'grid', x1: x(samples), x2: x(samples), y1: TOP, y2: HEIGHT - BOTTOM});
    draw(svg, 'text', {x: x(samples), y: HEIGHT - BOTTOM + 14, 'text-anchor': 'middle'}, samples);
  }
  const levels = ticks(low, high, high / low > 30 ? [1] : [1, 2, 5], 10);
  for (const error of levels) {
    draw(svg, 'line', {class: 'grid', x1: LEFT, x2: WIDTH - RIGHT, y1: y(error), y2: y(error)});
    draw(svg, 'text', {x: LEFT - 5, y: y(error) + 4, 'text-anchor': 'end'}, percent(error));
  }
  draw(svg, 'text', {x: (LEFT + WIDTH) / 2, y: HEIGHT - 4, 'text-anchor': 'middle'}, 'samples per pixel');
  const [start, first] = series[0].points[0];
  // Down to the lower border, or to the right one.
  const end = Math.min(most, start * (first / low) ** 2);
  draw(svg, 'line', {class: 'ideal', x1: x(start), y1: y(first), x2: x(end), y2: y(first * Math.sqrt(start / end))});
  series.forEach(({name, points: line, isClaimed}) => draw(svg, 'polyline', {
    class: `${name} ${isClaimed ? 'claimed' : ''}`,
    points: line.map(([samples, error]) => `${x(samples).toFixed(1)},${y(error).toFixed(1)}`).join(' ')}));
}
