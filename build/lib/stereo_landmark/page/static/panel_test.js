// Testing on another pair, the place in the map, and saving.

import { app, request, changed, edit } from './app.js';
import { byId, formatAngle, el, formatLength, toast } from './dom.js';

let isTesting = false;

export async function test() {
  if (isTesting) return;
  isTesting = true;
  changed();
  const pair = app.testPair ?? app.state.pair;
  const answer = await request('test', { pair });
  isTesting = false;
  app.test = answer.error ? { is_fix: false, text: answer.error, detections: [] } : answer.answer;
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
  else if (answer.saved) toast(`Saved: ${answer.saved}`);
}

function askToReplace(text) {
  const dialog = byId('dialog');
  dialog.replaceChildren(el('form', { method: 'dialog' }, el('h3', {}, 'Replace the place?'), el('p', {}, text),
    el('div', { className: 'row' }, el('span', { className: 'grow' }), el('button', {}, 'Keep it'),
      el('button', { className: 'primary', 'data-testid': 'replace', onclick: () => save(true) }, 'Replace'))));
  dialog.showModal();
}

function result() {
  const found = app.test;
  if (!found) return null;
  const rows = found.detections.map((each) => el('li', { className: `trial ${each.points.length ? 'found' : 'not_found'}` }, el('span', { className: 'mark' }),
    el('span', { className: 'name' }, each.target), el('b', {}, each.text ?? `${each.found.length} primitives, log-likelihood ratio ${each.log_likelihood_ratio.toFixed(0)}`)));
  const card = found.is_fix
    ? el('div', { className: 'pose' },
      ...[['ahead', `${found.x >= 0 ? '+' : '−'}${formatLength(Math.abs(found.x))}`], ['left', `${found.y >= 0 ? '+' : '−'}${formatLength(Math.abs(found.y))}`],
        ['yaw', formatAngle(found.yaw)], ['standard deviation', `± ${formatLength(found.position_sigma)}, ± ${formatAngle(found.yaw_sigma)}`], ['residual', `${found.residual.toFixed(2)} px`]]
        .map(([name, value]) => el('div', {}, el('span', {}, name), el('b', {}, value))))
    : el('p', { className: 'expected stop' }, el('b', {}, 'No pose'), el('span', {}, found.text));
  return el('div', { 'data-testid': 'test-result' }, card, el('ul', { className: 'trials' }, ...rows));
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
    field('yaw', 'yaw [°]', pose && Number((pose.yaw * 180 / Math.PI).toFixed(6))));
}

export function panelTest() {
  const pairs = app.state.pairs.map((label, i) => el('option', { value: i, selected: i === (app.testPair ?? app.state.pair) }, `${i + 1}: ${label}`));
  return [
    el('h2', {}, 'Test on another pair'),
    el('p', {}, 'Use images from near the taught pose, with other light or occlusions, to test localization.'),
    el('div', { className: 'row' },
      el('select', { 'data-testid': 'test-pair', onchange: (event) => { app.testPair = Number(event.target.value); app.test = null; changed(); test(); } }, ...pairs),
      el('button', { className: 'primary', 'data-testid': 'test', disabled: isTesting, title: 'Key T', onclick: test }, isTesting ? 'Testing …' : 'Test')),
    result(),
    el('h2', {}, 'Pose in the map'),
    el('p', {}, 'Pose of the robot at teaching time. Without it only the displacement is published.'),
    mapPose(),
    el('button', { className: 'wide primary', onclick: () => save() }, app.state.save_status === 'saved' ? 'Save again' : 'Save the place'),
  ];
}
