// SPDX-License-Identifier: Apache-2.0

'use strict';

/** Puts a plot in the place of its image, with ids of its own, so that its series answer to the pointer. */
function openPlot(image, index) {
  const source = decodeURIComponent(image.src.slice(image.src.indexOf(',') + 1));
  const own = source.replace(/(\bid=['"]|href=['"]#|url\(['"]?#)/g, `$1plot${index}-`);
  const svg = new DOMParser().parseFromString(own, 'image/svg+xml').documentElement;
  if (svg.nodeName !== 'svg') return;
  svg.setAttribute('class', 'plot');
  svg.setAttribute('role', 'img');
  svg.setAttribute('aria-label', image.alt);
  svg.querySelector(':scope > title')?.remove();  // the program's that drew it
  image.replaceWith(svg);
  chooseSeries(svg);
}

/** A series is a group with points or another colour than the one before, and what has its colour behind it: its fit. */
function chooseSeries(svg) {
  const groups = [...svg.querySelectorAll('g[id*=gnuplot_plot]')];
  const colourOf = group => group.querySelector('path[stroke^=rgb]')?.getAttribute('stroke');
  let series = 0, name = '', colour = null;
  const choose = chosen => {
    svg.classList.toggle('chosen', chosen !== null);
    for (const group of groups) group.classList.toggle('chosen', group.dataset.series === chosen);
  };
  for (const group of groups) {
    if (group.querySelector('use') || colourOf(group) !== colour) {
      series++;
      name = group.querySelector('text')?.textContent ?? '';
    }
    colour = colourOf(group);
    group.dataset.series = series;
    const title = group.querySelector('title');
    if (title) title.textContent = name;  // the program's that drew it is of no use
    group.onpointerenter = () => choose(group.dataset.series);
    group.onpointerleave = () => choose(null);
  }
}
