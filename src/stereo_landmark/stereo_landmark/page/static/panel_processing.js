// Step 1: from grey images to edges (paper 4a).

import { app, request, changed, publish, edit } from './app.js';
import { LatestValueQueue } from './connection.js';
import { byId, el } from './dom.js';
import { stage } from './stage.js';

const TITLES = {
  'edges.filter_sigma': 'Smoothing', 'edges.threshold': 'Threshold', 'edges.continuation': 'Continuation',
  'edges.length_min': 'Shortest line', 'edges.bend_tolerance': 'Bend tolerance',
};
/** What a slider does, where the description of the setting is for experts. */
const EFFECTS = {
  'edges.filter_sigma': 'more removes noise, but also small shapes', 'edges.threshold': 'higher keeps only clear edges, lower also faint ones',
  'edges.continuation': 'lower follows an edge further where it gets faint', 'edges.length_min': 'shorter lines are dropped',
  'edges.bend_tolerance': 'higher keeps slightly bent edges in one piece',
};
const STEPS = 400;
const GROUPS = [['edges', 'Edges', true], ['primitives', 'Shapes', false], ['tolerances', 'Tolerances when searching', false]];

let gestures = 0;

const decode = (text, Type) => new Type(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);

function storeEdges(answer) {
  for (const [side, edges] of Object.entries(answer.edges ?? {})) {
    app.edges[side] = { ...edges, points: decode(edges.points, Int16Array), starts: decode(edges.starts, Int32Array) };
  }
}

/** One request in flight, the latest value wins. */
export const edgeQueue = new LatestValueQueue(async ({ fields }) => {
  const began = performance.now();
  const answer = await request('edges', { sides: ['left', 'right'], ...fields });
  storeEdges(answer);
  edgeQueue.times.push(performance.now() - began);
  window.__drawing = { times: edgeQueue.times, sent: edgeQueue.sent, skipped: edgeQueue.skipped };
  publish();
  stage.redraw();
  showCounts();
});
edgeQueue.times = [];

export const drawEdges = () => edgeQueue.push({ fields: {} });

/** Sliders with a wide range are logarithmic. */
const isWide = ({ minimum, maximum }) => minimum > 0 && maximum / minimum > 20;
const toSlider = (setting, value) => Math.round(STEPS * (isWide(setting)
  ? Math.log(value / setting.minimum) / Math.log(setting.maximum / setting.minimum)
  : (value - setting.minimum) / (setting.maximum - setting.minimum)));
const fromSlider = (setting, place) => Number((isWide(setting)
  ? setting.minimum * (setting.maximum / setting.minimum) ** (place / STEPS)
  : setting.minimum + (setting.maximum - setting.minimum) * (place / STEPS)).toPrecision(3));

function slider(setting) {
  const value = app.state.processing[setting.name];
  const shortName = setting.name.split('.').slice(setting.name.startsWith('tolerances') ? 1 : -1).join(' ').replaceAll('_', ' ');
  const title = TITLES[setting.name] ?? shortName[0].toUpperCase() + shortName.slice(1);
  const number = el('output', {}, show(value, setting));
  const set = (next, fields) => {
    number.textContent = show(next, setting);
    return edgeQueue.push({ fields: { name: setting.name, value: next, ...fields } });
  };
  const bar = el('input', {
    type: 'range', min: 0, max: STEPS, value: toSlider(setting, value), 'data-testid': `slider-${setting.name}`, title: setting.description,
    onpointerdown: () => { gestures += 1; },
    oninput: () => { set(fromSlider(setting, Number(bar.value)), { gesture: `${setting.name} ${gestures}` }); },
    onchange: () => runDetectors(),
    ondblclick: () => { gestures += 1; bar.value = toSlider(setting, setting.default); set(setting.default, { gesture: `${setting.name} ${gestures}` }).then(runDetectors); },
  });
  return el('label', { className: `slider${value === setting.default ? '' : ' moved'}` },
    el('span', {}, title), number, bar, el('small', {}, EFFECTS[setting.name] ?? setting.description));
}

const show = (value, setting) => `${Number(value.toPrecision(3))}${setting.unit ? ` ${setting.unit}` : ''}`;

/** Run the detectors once after a drag. */
async function runDetectors() {
  while (edgeQueue.isBusy) await new Promise((done) => { setTimeout(done, 10); });
  await request('snapshot');
}

function showCounts() {
  const box = byId('edge-counts');
  if (box && app.edges.left) box.textContent = `${app.edges.left.count} lines left, ${app.edges.right?.count ?? '–'} right`;
}

export function panelProcessing() {
  const brightness = el('input', {
    type: 'range', min: 0, max: 100, value: 100 * (app.brightness ?? 0.35),
    oninput: (event) => { app.brightness = event.target.value / 100; changed(); },
  });
  const groups = GROUPS.map(([group, title, isOpen]) => {
    const settings = app.configuration.settings.filter((each) => each.name.startsWith(`${group}.`));
    return el('details', { open: app[`open-${group}`] ?? isOpen, ontoggle: (event) => { app[`open-${group}`] = event.target.open; } },
      el('summary', {}, title, el('button', {
        className: 'quiet', title: 'Back to the defaults',
        onclick: async (event) => { event.preventDefault(); await edit('reset', { group: `${group}.` }); drawEdges(); },
      }, 'Reset')), ...settings.map(slider));
  });
  return [
    el('h2', {}, 'Image processing'),
    el('p', {}, 'Drag until the outlines of your objects are closed lines with little noise around them. Each line has its own colour.'),
    el('p', { id: 'edge-counts', className: 'counts', 'data-testid': 'edge-counts' }, app.edges.left ? `${app.edges.left.count} lines left, ${app.edges.right?.count ?? '–'} right` : ''),
    ...groups,
    el('label', { className: 'slider' }, el('span', {}, 'Image behind the edges'), el('output', {}, ''), brightness),
  ];
}
