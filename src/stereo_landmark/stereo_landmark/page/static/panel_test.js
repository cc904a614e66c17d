// Testing on another pair, the place in the map, and saving.

import { app, ask, changed, step } from './app.js';
import { byId, degrees, el, millimetres, toast } from './dom.js';

let isTesting = false;

export async function test() {
  if (isTesting) return;
  isTesting = true;
  changed();
  const pair = app.testPair ?? app.state.pair;
  const answer = await ask('test', { pair });
  isTesting = false;
  app.test = answer.error ? { is_fix: false, text: answer.error, sightings: [] } : answer.answer;
  changed();
}

export async function save(replace = false) {
  const answer = await ask('save', { replace });
  if (answer.exists) { askToReplace(answer.error); return; }
  if (answer.saved) {
    app.isSaved = true;
    toast(`Saved: ${answer.saved}`);
    changed();
  }
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
  const rows = found.sightings.map((each) => el('li', { className: `trial ${each.points.length ? 'found' : 'missed'}` }, el('span', { className: 'mark' }),
    el('span', { className: 'name' }, each.target), el('b', {}, each.text ?? `${each.found.length} parts, evidence ${each.evidence.toFixed(0)}`)));
  const card = found.is_fix
    ? el('div', { className: 'pose' },
      ...[['ahead', `${found.x >= 0 ? '+' : '−'}${millimetres(Math.abs(found.x))}`], ['left', `${found.y >= 0 ? '+' : '−'}${millimetres(Math.abs(found.y))}`],
        ['turned', degrees(found.yaw)], ['certain to', `± ${millimetres(found.position_sigma)}, ± ${degrees(found.yaw_sigma)}`], ['misfit', `${found.residual.toFixed(2)} px`]]
        .map(([name, value]) => el('div', {}, el('span', {}, name), el('b', {}, value))))
    : el('p', { className: 'expected stop' }, el('b', {}, 'No pose'), el('span', {}, found.text));
  return el('div', { 'data-testid': 'test-result' }, card, el('ul', { className: 'trials' }, ...rows));
}

function mapPose() {
  const { pose } = app.state;
  const set = () => {
    const [x, y, yaw] = ['x', 'y', 'yaw'].map((name) => byId(`pose-${name}`).value.trim());
    if (x === '' && y === '' && yaw === '') { step('locate_place', { pose: null }); return; }
    if (x !== '' && y !== '' && yaw !== '') step('locate_place', { pose: [Number(x), Number(y), Number(yaw) * Math.PI / 180] });
  };
  const field = (name, title, value) => el('label', {}, title,
    el('input', { id: `pose-${name}`, 'data-testid': `pose-${name}`, type: 'number', step: 'any', value: value ?? '', onchange: set }));
  return el('div', { className: 'map-pose' }, field('x', 'x [m]', pose?.x), field('y', 'y [m]', pose?.y),
    field('yaw', 'heading [°]', pose && Number((pose.yaw * 180 / Math.PI).toFixed(6))));
}

export function panelTest() {
  const pairs = app.state.pairs.map((label, i) => el('option', { value: i, selected: i === (app.testPair ?? app.state.pair) }, `${i + 1}: ${label}`));
  return [
    el('h2', {}, 'Test on another pair'),
    el('p', {}, 'Take images from near the taught pose, with other light or something in the way, and see whether the robot finds itself.'),
    el('div', { className: 'row' },
      el('select', { 'data-testid': 'test-pair', onchange: (event) => { app.testPair = Number(event.target.value); app.test = null; changed(); test(); } }, ...pairs),
      el('button', { className: 'primary', 'data-testid': 'test', disabled: isTesting, title: 'Key T', onclick: test }, isTesting ? 'Testing …' : 'Test')),
    result(),
    el('h2', {}, 'Where in the map'),
    el('p', {}, 'The pose of the robot when it was taught. Without it the robot tells its displacement only.'),
    mapPose(),
    el('button', { className: 'wide primary', onclick: () => save() }, app.isSaved ? 'Save again' : 'Save the place'),
  ];
}
