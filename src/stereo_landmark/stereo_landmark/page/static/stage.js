// The pictures of the present part, and what lies under them.

import { activeTarget, app, changed, step } from './app.js';
import { COLOURS, KIND_NAMES, byId } from './dom.js';
import { middleOf, shapesAt } from './geometry.js';
import { PictureView, lens, resetLens, zoomLens } from './picture_view.js';
import { SpaceView } from './space_view.js';
import { treeView } from './tree_view.js';

const REACH = 9;
/** A hand that clicks may slip so far; who draws a region drags farther [px of the screen]. */
const SLIP = 10;
let views = {};
let space = null;
let drag = null;
let shownPart = null;

export const stage = {
  /** On the browser's page, for tests: where a place of the left image is. */
  onPage: (place, which = 'left') => views[which]?.onPage(place),
  cancelDrag: () => { const was = Boolean(drag); drag = null; redraw(); return was; },
  zoom: (factor) => { zoomLens(factor); redraw(); },
  /** Returns whether the pictures were zoomed in. */
  fit: () => { const was = lens.zoom > 1; resetLens(); redraw(); return was; },
  redraw: () => redraw(),
  hover: (name) => hover(name),
  nextShape: () => nextShape(),
};
window.__stage = stage;

const LAYOUTS = {
  processing: { pictures: ['left', 'right'] },
  targets: { pictures: ['left'] },
  points: { pictures: ['left', 'right'], below: true, isRow: true },
  tree: { pictures: ['left'], below: true },
  test: { pictures: ['taught', 'tested'] },
};
const TITLES = { left: 'Left camera', right: 'Right camera', taught: 'Taught', tested: 'Test pair' };

/** Build the pictures of a part, if they are not there. */
function build() {
  if (shownPart === app.part) return;
  shownPart = app.part;
  const layout = LAYOUTS[app.part];
  const { width, height } = app.greeting;
  views = Object.fromEntries(layout.pictures.map((which) => [which, new PictureView({
    title: TITLES[which], testid: `picture-${which}`, width, height, onLens: redraw,
    paint: (pen) => painters[app.part]?.(pen, which),
    pointer: which === 'left' || which === 'right' ? pointerOf(which) : { move: showCursor },
  })]));
  space = null;
  byId('pictures').replaceChildren(...Object.values(views).map((view) => view.element));
  byId('below').hidden = !layout.below;
  byId('pictures').className = layout.below ? 'shared' : '';
  if (app.part === 'points') {
    space = new SpaceView(app.greeting, spacePoints);
    byId('below').replaceChildren(space.element);
  }
  arrange();
}

/** Beside or below each other, whichever makes them larger. */
function arrange() {
  const box = byId('pictures');
  const { width, height } = app.greeting;
  const { clientWidth: w, clientHeight: h } = box;
  const count = Object.keys(views).length;
  const beside = Math.min(w / count / width, h / height), below = Math.min(w / width, h / count / height);
  const isRow = LAYOUTS[app.part].isRow || beside >= below;
  box.style.flexDirection = isRow ? 'row' : 'column';
}
new ResizeObserver(() => { if (app.greeting && shownPart) { arrange(); redraw(); } }).observe(byId('pictures'));

export function updateStage() {
  build();
  const { pair } = app.state;
  for (const [which, view] of Object.entries(views)) {
    const number = which === 'tested' ? app.testPair ?? pair : pair;
    view.show(`/image/${number}/${which === 'right' ? 'right' : 'left'}.png`);
    view.dim = app.part === 'processing' ? app.brightness ?? 0.35 : 1;
  }
  if (app.part === 'tree') byId('below').replaceChildren(treeView());
  const hovered = app.part === 'targets' && app.state.found.find((each) => keyOf(each) === app.hover);
  if (hovered) byId('cursor').textContent = describe(hovered);
  redraw();
}

function redraw() {
  Object.values(views).forEach((view) => view.draw());
  space?.draw();
}

function showCursor(place, _event, view) {
  const { width, height } = app.greeting;
  const isInside = place[0] > -0.5 && place[1] > -0.5 && place[0] < width - 0.5 && place[1] < height - 0.5;
  byId('cursor').textContent = isInside ? `${place[0].toFixed(1)}, ${place[1].toFixed(1)} px` : '';
  view.canvas.style.cursor = app.part === 'targets' ? 'crosshair' : 'default';
}

const reach = () => REACH / views.left.placing.scale;

/** What the pointer does in a part: regions and primitives in 'targets', points in 'points'. */
function pointerOf(which) {
  return {
    down: (place) => {
      if (app.part === 'targets') drag = { from: place, to: place };
      if (app.part === 'points') togglePointAt(place, which);
    },
    move: (place, event, view) => {
      showCursor(place, event, view);
      if (drag) { drag.to = place; redraw(); return; }
      hoverAt(place, which, view);
    },
    up: (place) => {
      if (!drag) return;
      const { from } = drag;
      drag = null;
      if (Math.hypot(place[0] - from[0], place[1] - from[1]) * views.left.placing.scale < SLIP) chooseAt(from);
      else step('draw_region', { region: rectangle(from, place) });
      redraw();
    },
    leave: () => hover(null),
  };
}

function rectangle(a, b) {
  const { width, height } = app.greeting;
  const inside = (value, limit) => Math.min(limit - 0.5, Math.max(-0.5, value));
  return [inside(Math.min(a[0], b[0]), width), inside(Math.min(a[1], b[1]), height),
    inside(Math.max(a[0], b[0]), width), inside(Math.max(a[1], b[1]), height)];
}

const keyOf = (found) => `${found.kind} ${found.number}`;

/** Where several shapes lie upon each other, the key X goes from one to the next. */
let turn = { among: '', count: 0 };
let last = null;

function meant(place) {
  const shapes = shapesAt(app.state.found, (each) => each.outline, place, reach());
  const among = shapes.map(keyOf).join();
  if (among !== turn.among) turn = { among, count: 0 };
  return shapes[turn.count % shapes.length] ?? null;
}

function nextShape() {
  if (app.part !== 'targets' || !last) return;
  turn.count += 1;
  hoverAt(last.place, last.which, last.view);
}

function hoverAt(place, which, view) {
  let under = null;
  if (app.part === 'targets') {
    last = { place, which, view };
    const found = meant(place);
    under = found && keyOf(found);
    view.canvas.style.cursor = found ? 'pointer' : 'crosshair';
    if (found) byId('cursor').textContent = describe(found);
  } else if (app.part === 'points') {
    under = pointAt(place, which)?.name ?? null;
    view.canvas.style.cursor = under ? 'pointer' : 'default';
  }
  hover(under);
}

/** Show what is under the pointer; the panel stays as it is, for the pointer may be in it. */
function hover(name) {
  if (name === app.hover) return;
  app.hover = name;
  document.querySelectorAll('[data-hover]').forEach((row) => row.classList.toggle('hovered', row.dataset.hover === name));
  redraw();
}

function describe(found) {
  const depth = found.depth === null ? 'not seen by the right camera' : `${found.depth.toFixed(2)} m away`;
  return `${KIND_NAMES[found.kind]}, ${depth}${found.chosen ? ` · chosen as ${found.chosen}` : ''}`;
}

async function chooseAt(place) {
  const found = meant(place);
  if (!found) { app.selected = null; changed(); return; }
  const answer = await step('toggle', { kind: found.kind, number: found.number });
  if (answer.error) return;
  app.selected = app.state.found.find((each) => keyOf(each) === keyOf(found))?.chosen ?? null;
  changed();
}

function pointAt(place, which) {
  const near = activeTarget().points.map((point) => ({ point, away: Math.hypot(point[which][0] - place[0], point[which][1] - place[1]) }))
    .sort((a, b) => a.away - b.away)[0];
  return near && near.away < 2 * reach() ? near.point : null;
}

function togglePointAt(place, which) {
  const point = pointAt(place, which);
  if (point) step('use_points', { points: [point.name], used: !point.used });
}

const colourOf = (primitive) => COLOURS[primitive.kind];

function paintChosen(pen, side, { withBadges = true, faint = false } = {}) {
  activeTarget().primitives.forEach((part, i) => {
    const lines = part[side];
    if (!lines.length) return;
    const isSelected = part.name === app.selected;
    pen.lines(lines, faint ? `${colourOf(part)}88` : colourOf(part), isSelected ? 3.5 : faint ? 1.5 : 2.5, { glow: !faint, fill: isSelected ? `${colourOf(part)}33` : null });
    if (withBadges) pen.badge(middleOf(lines), String(i + 1), part.fault ? '#ff6b6b' : colourOf(part));
  });
  app.state.targets.forEach((target, k) => {
    if (k !== app.state.active) target.primitives.forEach((part) => pen.lines(part[side], '#ffffff66', 1.5));
  });
}

const painters = {
  processing: (pen, which) => { if (app.edges[which]) pen.edges(app.edges[which]); },
  targets: (pen) => {
    const region = drag ? rectangle(drag.from, drag.to) : activeTarget().region;
    if (region) pen.spotlight(region);
    if (drag) return;
    for (const found of app.state.found) {
      if (found.chosen) continue;
      const colour = found.depth === null ? '#9fb1bb' : COLOURS[found.kind];
      if (keyOf(found) !== app.hover) pen.lines(found.outline, `${colour}${found.depth === null ? '55' : 'b0'}`, 1.2, { dash: found.depth === null ? [3, 4] : [] });
    }
    paintChosen(pen, 'left');
    const hovered = app.state.found.find((each) => keyOf(each) === app.hover);
    if (hovered) pen.lines(hovered.outline, '#ffffff', 3, { glow: true });
  },
  points: (pen, which) => {
    paintChosen(pen, which, { withBadges: false, faint: true });
    for (const point of activeTarget().points) {
      pen.cross(point[which], point.used ? '#ffffff' : '#7d93a0', point.used ? 6 : 4, point.used ? 2 : 1.2);
      if (point.name === app.hover) pen.ring(point[which], '#ffffff', 11);
    }
  },
  tree: (pen) => paintChosen(pen, 'left'),
  test: (pen, which) => {
    if (which === 'taught') { app.state.targets.forEach((target) => target.points.filter((p) => p.used).forEach((p) => pen.cross(p.left, '#ffffff'))); paintChosen(pen, 'left', { withBadges: false, faint: true }); }
    if (which === 'tested') app.test?.sightings.forEach((s) => s.points.forEach((p) => { pen.cross(p.left, p.used ? '#7ae582' : '#ffb703', 8); }));
  },
};

function spacePoints() {
  return app.state.targets.flatMap((target, k) => target.points.map((point) => {
    const part = target.primitives.find((each) => point.name.startsWith(`${each.name}/`));
    return { ...point, colour: k === app.state.active ? colourOf(part) : '#b9c7cf', isHovered: k === app.state.active && point.name === app.hover, label: point.name };
  }));
}

