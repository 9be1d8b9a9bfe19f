// SPDX-License-Identifier: Apache-2.0

// What pointers and keys do on the picture. `act` is told: press(x, y) returns whether there is a
// thing to drag; drag(dx, dy, isUpright), orbit(dx, dy), pan(dx, dy), zoom(factor), select(x, y),
// end(). Places are from 0 to 1 from the upper left corner, steps in parts of the picture's width.
const CLICK = 4;  // pixels that a pointer may move between press and release

export function listen(canvas, act) {
  const pointers = new Map();
  let drags = false, start = null, moved = false;

  const place = event => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  };
  const span = () => {
    const [a, b] = [...pointers.values()];
    return {middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], size: Math.hypot(a[0] - b[0], a[1] - b[1])};
  };

  canvas.addEventListener('pointerdown', event => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus();
    pointers.set(event.pointerId, place(event));
    if (pointers.size === 1) {
      [start, moved] = [[event.clientX, event.clientY], false];
      drags = event.button === 0 && act.press(...place(event));
    }
    event.preventDefault();
  });

  canvas.addEventListener('pointermove', event => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const now = place(event), step = [now[0] - before[0], now[1] - before[1]];
    moved ||= Math.hypot(event.clientX - start[0], event.clientY - start[1]) > CLICK;
    if (!moved) return;
    if (pointers.size === 2) {
      const old = span();
      pointers.set(event.pointerId, now);
      const {middle, size} = span();
      act.pan(middle[0] - old.middle[0], middle[1] - old.middle[1]);
      act.zoom(old.size / Math.max(size, 1e-3));
      return;
    }
    pointers.set(event.pointerId, now);
    if (drags) act.drag(...step, event.shiftKey);
    else if (event.shiftKey || event.buttons > 1) act.pan(...step);
    else act.orbit(...step);
  });

  const release = event => {
    if (!pointers.delete(event.pointerId) || pointers.size > 0) return;
    if (!moved && event.type === 'pointerup') act.select(...place(event));
    act.end();
  };
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);
  canvas.addEventListener('contextmenu', event => event.preventDefault());

  let wheeling;
  canvas.addEventListener('wheel', event => {
    event.preventDefault();
    act.zoom(2 ** (Math.max(-200, Math.min(event.deltaY, 200)) / 400));
    clearTimeout(wheeling);
    wheeling = setTimeout(() => act.end(), 200);
  }, {passive: false});

  canvas.addEventListener('keydown', event => {
    const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
    const step = steps[event.key]?.map(part => part * 0.04);
    if (step && event.shiftKey) act.pan(...step);
    else if (step) act.orbit(...step);
    else if (event.key === '+' || event.key === '=') act.zoom(0.9);
    else if (event.key === '-') act.zoom(1 / 0.9);
    else return;
    event.preventDefault();
    act.end();
  });
}
