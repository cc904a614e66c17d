// The pictures of the current step, and the view below them.

import { activeTarget, app, changed, edit } from './app.js';
import { COLOURS, KIND_NAMES, byId, el, toast } from './dom.js';
import { centreOf, distanceToLine, shapesAt } from './geometry.js';
import { PictureView, viewport, resetViewport, zoomViewport } from './picture_view.js';
import { areaWords, planView } from './plan_view.js';
import { SpaceView } from './space_view.js';
import { treeView } from './tree_view.js';

const isNarrow = matchMedia('(max-width: 900px)');
const HIT_RADIUS = 9;
/** Maximum movement of a click; longer drags draw a region [px of the screen]. */
const CLICK_DISTANCE = 10;
let views = {};
let space = null;
let drag = null;
let shownStep = null;

export const stage = {
  /** Position of a point of the left image on the browser's page, for tests. */
  onPage: (place, which = 'left') => views[which]?.onPage(place),
  cancelDrag: () => { const was = Boolean(drag); drag = null; redraw(); return was; },
  zoom: (factor) => { zoomViewport(factor); redraw(); },
  /** Reset the zoom; return whether the pictures were zoomed in. */
  fit: () => { const was = viewport.zoom > 1; resetViewport(); redraw(); return was; },
  redraw: () => redraw(),
  hover: (name) => hover(name),
  nextShape: () => nextShape(),
  keyOf: (found) => keyOf(found),
  choose: (found) => choose(found),
};
window.__stage = stage;

const LAYOUTS = {
  processing: { pictures: ['left', 'right'] },
  targets: { pictures: ['left'] },
  points: { pictures: ['left', 'right'], below: true, isRow: true },
  tree: { pictures: ['left'], below: true },
  test: { pictures: ['taught', 'tested'], below: true, isRow: true },
};
const TITLES = { left: 'Left camera', right: 'Right camera', taught: 'Taught', tested: 'Test image' };

/** Create the pictures of a step, if they do not exist. */
function build() {
  if (shownStep === app.step) return;
  shownStep = app.step;
  const layout = LAYOUTS[app.step];
  const { width, height } = app.configuration;
  views = Object.fromEntries(layout.pictures.map((which) => [which, new PictureView({
    title: TITLES[which], testid: `picture-${which}`, width, height, onViewportChange: redraw,
    paint: (pen) => painters[app.step]?.(pen, which),
    pointer: which === 'left' || which === 'right' ? pointerOf(which) : { move: showCursor },
  })]));
  space = null;
  byId('pictures').replaceChildren(...Object.values(views).map((view) => view.element));
  byId('below').hidden = !layout.below;
  byId('pictures').className = layout.below ? 'shared' : '';
  if (app.step === 'points') {
    space = new SpaceView(app.configuration, spacePoints);
    byId('below').replaceChildren(space.element);
  }
  layOut();
}

/** Arrange pictures in a row or a column, whichever makes them larger. */
function layOut() {
  const box = byId('pictures');
  const { width, height } = app.configuration;
  const { clientWidth: w, clientHeight: h } = box;
  const count = Object.keys(views).length;
  const inRow = Math.min(w / count / width, h / height), inColumn = Math.min(w / width, h / count / height);
  const isRow = LAYOUTS[app.step].isRow || isNarrow.matches || inRow >= inColumn;
  box.style.flexDirection = isRow ? 'row' : 'column';
  box.style.setProperty('--ratio', `${width} / ${height}`);
}
new ResizeObserver(() => { if (app.configuration && shownStep) { layOut(); redraw(); } }).observe(byId('pictures'));

export function updateStage() {
  build();
  const { pair } = app.state;
  for (const [which, view] of Object.entries(views)) {
    const number = which === 'tested' ? app.testPair ?? pair : pair;
    view.show(`/image/${number}/${which === 'right' ? 'right' : 'left'}.png`);
    view.dim = app.step === 'processing' ? app.brightness ?? 0.35 : 1;
  }
  showBelow();
  const hovered = app.step === 'targets' && app.state.found.find((each) => keyOf(each) === app.hover);
  if (hovered) byId('cursor').textContent = describe(hovered);
  redraw();
}

/** The tree or the plan, as wide as the view below the pictures. */
function showBelow() {
  if (app.step === 'tree') byId('below').replaceChildren(treeView(byId('below').clientWidth));
  if (app.step !== 'test') return;
  const words = el('p', { 'data-testid': 'area' }, areaWords());
  const box = el('div', { className: 'plan-box' });
  byId('below').replaceChildren(el('section', { className: 'plan-view', 'aria-label': 'Plan' }, words, box));
  if (box.clientWidth && box.clientHeight) box.append(planView(box.clientWidth, box.clientHeight));
}
new ResizeObserver(() => { if (app.state && shownStep) showBelow(); }).observe(byId('below'));

function redraw() {
  Object.values(views).forEach((view) => view.draw());
  space?.draw();
}

function showCursor(place, _event, view) {
  const { width, height } = app.configuration;
  const isInside = place[0] > -0.5 && place[1] > -0.5 && place[0] < width - 0.5 && place[1] < height - 0.5;
  byId('cursor').textContent = isInside ? `${place[0].toFixed(1)}, ${place[1].toFixed(1)} px` : '';
  view.canvas.style.cursor = app.step === 'targets' ? 'crosshair' : 'default';
}

const hitRadius = () => HIT_RADIUS / views.left.placing.scale;

/** Pointer handlers of a step: regions and primitives in 'targets', points in 'points'. */
function pointerOf(which) {
  return {
    down: (place) => {
      if (app.step === 'targets') drag = { from: place, to: place };
      if (app.step === 'points') togglePointAt(place, which);
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
      if (Math.hypot(place[0] - from[0], place[1] - from[1]) * views.left.placing.scale < CLICK_DISTANCE) chooseAt(from);
      else edit('set_region', { region: rectangle(from, place) });
      redraw();
    },
    cancel: () => stage.cancelDrag(),
    leave: () => hover(null),
  };
}

function rectangle(a, b) {
  const { width, height } = app.configuration;
  const inside = (value, limit) => Math.min(limit - 0.5, Math.max(-0.5, value));
  return [inside(Math.min(a[0], b[0]), width), inside(Math.min(a[1], b[1]), height),
    inside(Math.max(a[0], b[0]), width), inside(Math.max(a[1], b[1]), height)];
}

const keyOf = (found) => `${found.kind} ${found.number}`;

/** The key X cycles through overlapping shapes. */
let cycle = { among: '', count: 0 };
let last = null;

function shapeUnder(place) {
  const shapes = preferUsable(shapesAt(app.state.found, (each) => each.outline, place, hitRadius()), place);
  const among = shapes.map(keyOf).join();
  if (among !== cycle.among) cycle = { among, count: 0 };
  return shapes[cycle.count % shapes.length] ?? null;
}

/** Of shapes whose outlines are at the pointer, those that can be used come first. */
function preferUsable(shapes, place) {
  const isFirst = (each) => !each.fault && Math.min(...each.outline.map((line) => distanceToLine(place, line))) <= hitRadius();
  return [...shapes.filter(isFirst), ...shapes.filter((each) => !isFirst(each))];
}

function nextShape() {
  if (app.step !== 'targets' || !last) return;
  cycle.count += 1;
  hoverAt(last.place, last.which, last.view);
}

function hoverAt(place, which, view) {
  let under = null;
  if (app.step === 'targets') {
    last = { place, which, view };
    const found = shapeUnder(place);
    under = found && keyOf(found);
    view.canvas.style.cursor = !found ? 'crosshair' : isRefused(found) ? 'not-allowed' : 'pointer';
    if (found) byId('cursor').textContent = describe(found);
  } else if (app.step === 'points') {
    under = pointAt(place, which)?.name ?? null;
    view.canvas.style.cursor = under ? 'pointer' : 'default';
  }
  hover(under);
}

/** Highlight the item under the pointer without rebuilding the panel, which may contain the pointer. */
function hover(name) {
  if (name === app.hover) return;
  app.hover = name;
  const shape = app.step === 'targets' && app.state.found.find((each) => keyOf(each) === name);
  byId('reason').textContent = shape && isRefused(shape) ? describe(shape) : '';
  document.querySelectorAll('[data-hover]').forEach((row) => row.classList.toggle('hovered', row.dataset.hover === name));
  redraw();
}

const isRefused = (found) => Boolean(found.fault) && !found.chosen;

function describe(found) {
  if (found.fault) return `${KIND_NAMES[found.kind]} cannot be used: ${found.fault}`;
  return `${KIND_NAMES[found.kind]}, ${found.depth.toFixed(2)} m away${found.chosen ? ` · selected as ${found.chosen}` : ''}`;
}

async function chooseAt(place) {
  const found = shapeUnder(place);
  if (found) await choose(found);
  else { app.selected = null; changed(); }
}

/** Select a shape, or remove it; for one that cannot be used, say why. */
async function choose(found) {
  if (isRefused(found)) { toast(describe(found), true); return; }
  const answer = await edit('toggle', { kind: found.kind, number: found.number });
  if (answer.error) return;
  app.selected = app.state.found.find((each) => keyOf(each) === keyOf(found))?.chosen ?? null;
  changed();
}

function pointAt(place, which) {
  const near = activeTarget().points.map((point) => ({ point, distance: Math.hypot(point[which][0] - place[0], point[which][1] - place[1]) }))
    .sort((a, b) => a.distance - b.distance)[0];
  return near && near.distance < 2 * hitRadius() ? near.point : null;
}

function togglePointAt(place, which) {
  const point = pointAt(place, which);
  if (point) edit('set_points_used', { points: [point.name], used: !point.used });
}

const colourOf = (primitive) => COLOURS[primitive.kind];

function paintChosen(pen, side, { withBadges = true, faint = false } = {}) {
  activeTarget().primitives.forEach((primitive, i) => {
    const lines = primitive[side];
    if (!lines.length) return;
    const isSelected = primitive.name === app.selected;
    pen.lines(lines, faint ? `${colourOf(primitive)}88` : colourOf(primitive), isSelected ? 3.5 : faint ? 1.5 : 2.5, { glow: !faint, fill: isSelected ? `${colourOf(primitive)}33` : null });
    if (withBadges) pen.badge(centreOf(lines), String(i + 1), primitive.fault ? '#ff6b6b' : colourOf(primitive));
  });
  app.state.targets.forEach((target, k) => {
    if (k !== app.state.active) target.primitives.forEach((primitive) => pen.lines(primitive[side], '#ffffff66', 1.5));
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
      if (keyOf(found) === app.hover) continue;
      if (found.fault) pen.lines(found.outline, '#9fb1bb66', 1, { dash: [2, 4] });
      else pen.lines(found.outline, `${COLOURS[found.kind]}d0`, 1.6);
    }
    paintChosen(pen, 'left');
    const hovered = app.state.found.find((each) => keyOf(each) === app.hover);
    if (hovered) pen.lines(hovered.outline, isRefused(hovered) ? '#ff6b6b' : '#ffffff', isRefused(hovered) ? 2 : 3, { glow: true, dash: isRefused(hovered) ? [4, 4] : [] });
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
    if (which === 'tested') app.test?.detections.forEach((s) => s.points.forEach((p) => { pen.cross(p.left, p.used ? '#7ae582' : '#ffb703', 8); }));
  },
};

function spacePoints() {
  return app.state.targets.flatMap((target, k) => target.points.map((point) => {
    const primitive = target.primitives.find((each) => point.name.startsWith(`${each.name}/`));
    return { ...point, colour: k === app.state.active ? colourOf(primitive) : '#b9c7cf', isHovered: k === app.state.active && point.name === app.hover, label: point.name };
  }));
}

