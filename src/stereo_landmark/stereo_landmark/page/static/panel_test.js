// Testing on another pair, the place in the map, and saving.

import { app, request, changed, edit } from './app.js';
import { byId, formatAngle, el, formatLength, toast } from './dom.js';
import { missingNames, plain } from './words.js';

let isTesting = false;
/** Whether image or tilt changed during a test. */
let isOutdated = false;
const shownPair = () => app.testPair ?? app.state.pair;
const degrees = (radians) => Number((radians * 180 / Math.PI).toFixed(2));

const ask = (pair) => request('test', { pair, tilt: app.tilts[pair] });

export async function test() {
  if (isTesting) { isOutdated = true; return; }
  isTesting = true;
  changed();
  let answer = null;
  do {
    isOutdated = false;
    answer = await ask(shownPair());
  } while (isOutdated);
  isTesting = false;
  app.test = answer.error ? { is_fix: false, reason: answer.error, detail: '', detections: [], pair: shownPair() } : answer.answer;
  changed();
}

/** Test all images one after the other, until the selection changes or the engineer stops. */
async function testAll() {
  const { selection, pairs } = app.state;
  app.testing = 0;
  changed();
  while (app.testing !== null && app.testing < pairs.length && app.state.selection === selection) {
    const answer = await ask(app.testing);
    if (answer.error) break;
    if (app.testing === shownPair()) app.test = answer.answer;
    if (app.testing !== null) app.testing += 1;
  }
  app.testing = null;
  changed();
}

/** Mark an invalid name in the header; the state does not overwrite it. */
export function markName(isRefused) {
  byId('place').dataset.isOwn = String(isRefused);
  byId('place').setAttribute('aria-invalid', String(isRefused));
}

/** Submit the name in the header; an invalid name stays there, marked, until it is corrected or cancelled. */
export async function submitName() {
  const field = byId('place');
  const name = field.value.trim();
  field.dataset.isOwn = 'true';
  const answer = name === app.state.place ? {} : await edit('rename_place', { name });
  markName(Boolean(answer.error));
  changed();
  return answer;
}

/** Save the place, including pending input; invalid input prevents saving. */
export async function save(replace = false) {
  if (app.isSaving) return;
  if (document.activeElement?.matches('input')) document.activeElement.blur();
  app.isSaving = true;
  changed();
  const last = await app.pending;
  const named = last?.error ? last : await submitName();
  const answer = named.error ? named : await request('save', { replace });
  app.isSaving = false;
  changed();
  if (answer.exists) askToReplace(answer.error);
  else if (answer.saved) toast([`Saved: ${answer.saved}`, ...answer.left_out].join('\n'));
}

function askToReplace(text) {
  const dialog = byId('dialog');
  dialog.replaceChildren(el('form', { method: 'dialog' }, el('h3', {}, 'Replace the place?'), el('p', {}, text),
    el('div', { className: 'row' }, el('span', { className: 'grow' }), el('button', {}, 'Keep it'),
      el('button', { className: 'primary', 'data-testid': 'replace', onclick: () => save(true) }, 'Replace'))));
  dialog.showModal();
}

/** What was found of each target; shapes that were not found are named. */
function detectionRow(target) {
  const detection = app.test.detections.find((each) => each.target === target.name);
  const [missing] = missingNames([target], { [target.name]: detection?.found ?? [] });
  const usable = target.primitives.filter((each) => !each.fault).length;
  const state = !missing ? 'found' : detection?.found.length ? 'ambiguous' : 'not_found';
  return el('li', { className: `trial ${state}`, 'data-testid': 'detection' }, el('span', { className: 'mark' }),
    el('span', { className: 'name' }, missing ? `Not found: ${missing}` : target.name, detection?.reason && el('small', { title: detection.detail }, plain(detection.reason))),
    el('b', {}, `${detection?.found.length ?? 0} of ${usable} shapes`));
}

function result() {
  const found = app.test;
  if (!found) return null;
  const side = (value) => `${value >= 0 ? '+' : '−'}${formatLength(Math.abs(value))}`;
  const card = found.is_fix
    ? el('div', { className: 'pose' },
      ...[['ahead', side(found.x)], ['left', side(found.y)], ['turned', formatAngle(found.yaw)],
        ['uncertainty', `± ${formatLength(found.position_sigma)}, ± ${formatAngle(found.yaw_sigma)}`]]
        .map(([name, value]) => el('div', {}, el('span', {}, name), el('b', {}, value))))
    : el('div', { className: 'expected stop' }, el('b', {}, 'No position'), el('span', {}, plain(found.reason)),
      found.detail && el('details', {}, el('summary', {}, 'For the expert'), el('small', {}, found.detail)));
  return el('div', { 'data-testid': 'test-result' }, card, found.detections.length > 0 && el('ul', { className: 'trials' }, ...app.state.targets.map(detectionRow)));
}

/** Roll and pitch of the test image; what was measured, unless it is set here. */
function tilt() {
  const pair = shownPair();
  const now = app.tilts[pair] ?? (app.test?.pair === pair ? app.test.tilt : null);
  const set = () => {
    const values = ['roll', 'pitch'].map((name) => Number(byId(`tilt-${name}`).value) * Math.PI / 180);
    app.tilts[pair] = values;
    test();
  };
  const field = (name, title, value) => el('label', {}, title,
    el('input', { id: `tilt-${name}`, 'data-testid': `tilt-${name}`, type: 'number', step: 0.1, min: -45, max: 45, value: value === undefined ? '' : degrees(value), onchange: set }));
  return el('div', { className: 'map-pose tilt' }, field('roll', 'tilt sideways [°]', now?.[0]), field('pitch', 'tilt forward [°]', now?.[1]),
    el('button', { 'data-testid': 'tilt-measured', disabled: !app.tilts[pair], title: 'Use the tilt that was recorded with the image', onclick: () => { delete app.tilts[pair]; test(); } }, 'As recorded'));
}

function testedImages() {
  const entries = Object.entries(app.state.tests);
  if (entries.length < 2) return null;
  return el('details', { className: 'shapes', open: app['open-tests'] ?? false, ontoggle: (event) => { app['open-tests'] = event.target.open; } },
    el('summary', {}, el('span', {}, `${entries.filter(([, each]) => each.is_fix).length} of ${entries.length} tested images give a position`)),
    el('ul', {}, ...entries.map(([pair, each]) => {
      const missing = missingNames(app.state.targets, each.found);
      const words = each.is_fix ? `± ${formatLength(each.position_sigma)}` : plain(each.reason);
      return el('li', {}, el('button', { className: `shape${each.is_fix ? '' : ' refused'}`, 'aria-pressed': String(Number(pair) === shownPair()), onclick: () => show(Number(pair)) },
        el('span', { className: 'name' }, app.state.pairs[pair]), el('small', {}, missing.length && each.is_fix ? `${words}; not found: ${missing.join(', ')}` : words)));
    })));
}

function show(pair) {
  app.testPair = pair;
  app.test = null;
  changed();
  test();
}

function mapPose() {
  const { pose } = app.state;
  const set = () => {
    const [x, y, yaw] = ['x', 'y', 'yaw'].map((name) => byId(`pose-${name}`).value.trim());
    if (x === '' && y === '' && yaw === '') { edit('set_map_pose', { pose: null }); return; }
    if (x !== '' && y !== '' && yaw !== '') edit('set_map_pose', { pose: [Number(x), Number(y), Number(yaw) * Math.PI / 180] });
  };
  const field = (name, title, value) => el('label', {}, title,
    el('input', { id: `pose-${name}`, 'data-testid': `pose-${name}`, type: 'number', step: 'any', value: value ?? '', onchange: set }));
  return el('div', { className: 'map-pose' }, field('x', 'x [m]', pose?.x), field('y', 'y [m]', pose?.y),
    field('yaw', 'heading [°]', pose && Number((pose.yaw * 180 / Math.PI).toFixed(6))));
}

export function panelTest() {
  const { pairs } = app.state;
  const isRunning = app.testing !== null;
  const options = pairs.map((label, i) => el('option', { value: i, selected: i === shownPair() }, `${i + 1}: ${label}`));
  return [
    el('h2', {}, 'Test on other images'),
    el('p', {}, 'Use images from around the taught position, with other light, or with shapes hidden.'),
    el('div', { className: 'row' },
      el('select', { 'data-testid': 'test-pair', 'aria-label': 'Test image', onchange: (event) => show(Number(event.target.value)) }, ...options),
      el('button', { className: 'primary', 'data-testid': 'test', disabled: isTesting || isRunning, title: 'Key T', onclick: test }, isTesting ? 'Testing …' : 'Test')),
    tilt(),
    pairs.length > 1 && el('button', { className: 'wide', 'data-testid': 'test-all', onclick: () => { if (isRunning) app.testing = null; else testAll(); } },
      isRunning ? `Tested ${app.testing} of ${pairs.length} · Stop` : `Test all ${pairs.length} images`),
    result(), testedImages(),
    el('h2', {}, 'Position on the map'),
    el('p', {}, 'Where the robot stood when teaching. Without it the robot only knows where it is relative to this place.'),
    mapPose(),
    el('button', { className: 'wide primary', onclick: () => save() }, app.state.save_status === 'saved' ? 'Save again' : 'Save the place'),
  ];
}
