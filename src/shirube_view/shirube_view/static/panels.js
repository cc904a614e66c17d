// The cards beside the map.

import { byId, colour, degrees, el, fill, length } from './dom.js';
import { SOURCES, poseOf, robot, state } from './state.js';

const OLD = 1500; // a value that arrived earlier is not shown as current [ms]
const WORDS = { 0: ['good', 'fine'], 1: ['weak', 'warning'], 2: ['bad', 'error'], 3: ['bad', 'silent'] };
const PLAIN_REASONS = {
  used: 'used', 'no message': 'no pose yet',
};

const isNew = (name) => performance.now() - (state.arrived[name] ?? -1e9) < OLD;
const node = (name) => Object.values(state.diagnostics).find((each) => each.name.startsWith(`${name}:`) || each.name.includes(`/${name}:`) || each.name.startsWith(name));
const value = (status, key) => status?.values.find((each) => each.key === key)?.value;

function numberCell(title, text) {
  return el('div', {}, el('span', {}, title), el('b', {}, text));
}

function updatePose() {
  const at = robot();
  const twist = state.values.fused?.twist?.twist ?? state.values.odom?.twist?.twist;
  const covariance = state.values.fused?.pose?.covariance;
  const truth = poseOf(state.values.truth);
  const sigma = covariance ? Math.sqrt(Math.max(covariance[0], covariance[7])) : null;
  const isSameTime = truth && at && Math.abs(truth.stamp - at.stamp) < 0.05;
  fill('numbers', [
    numberCell('x', at ? `${at.x.toFixed(3)} m` : '–'), numberCell('y', at ? `${at.y.toFixed(3)} m` : '–'),
    numberCell('heading', at ? degrees(at.yaw) : '–'), numberCell('σ', sigma === null ? '–' : length(sigma)),
    numberCell('speed', twist ? `${Math.abs(twist.linear.x) < 0.005 ? '0.00' : twist.linear.x.toFixed(2)} m/s` : '–'),
    numberCell('turning', twist ? `${(twist.angular.z * 180 / Math.PI).toFixed(0)}°/s` : '–'),
    ...(truth && state.values.fused && isSameTime ? [numberCell('true error', length(Math.hypot(truth.x - at.x, truth.y - at.y)))] : []),
  ]);
}

function verdict(name) {
  const said = value(node('pose_arbiter'), name);
  if (said && isNew(`diagnostics/${node('pose_arbiter').name}`)) {
    const level = said === 'used' ? 'good' : said.startsWith('rejected') ? 'bad' : said.startsWith('no message') ? 'soft' : 'weak';
    return [level, PLAIN_REASONS[said] ?? said];
  }
  return isNew(name) ? ['good', 'gives poses'] : ['soft', 'silent'];
}

function updateSources() {
  fill('source-list', Object.entries(SOURCES).map(([name, title]) => {
    const [level, text] = verdict(name);
    const own = node(name);
    const why = own && level !== 'good' ? `: ${own.message}` : '';
    const covariance = state.values[name]?.pose?.covariance;
    const sigma = covariance && isNew(name) ? ` ±${length(Math.sqrt(Math.max(covariance[0], covariance[7])))}` : '';
    return el('li', {}, el('i', { style: `background: ${colour(name)}`, className: `dot-${name}` }), el('span', { className: 'name' }, title), el('span', { className: 'what' }, el('b', { className: level }, text), `${sigma}${why}`));
  }));
  for (const name of Object.keys(SOURCES)) byId('source-list').querySelectorAll(`.dot-${name}`).forEach((dot) => { dot.style.background = colour(name); });
}

function updateMotion() {
  const planner = node('reward_planner');
  let monitor = null;
  try { monitor = state.values.monitor && JSON.parse(state.values.monitor.data); } catch { monitor = null; }
  const rows = [];
  if (planner) rows.push(['Planner', WORDS[planner.level]?.[0] ?? 'soft', planner.message]);
  if (monitor && isNew('monitor')) rows.push(['Safety', { STOP: 'bad', stop: 'bad', fault: 'bad', none: 'good' }[monitor.action] ?? 'weak', `${monitor.reason}${monitor.source ? ` (${monitor.source})` : ''}`]);
  const goal = poseOf(state.values.goal);
  if (goal) rows.push(['Goal', 'soft', `x ${goal.x.toFixed(2)} m, y ${goal.y.toFixed(2)} m, ${degrees(goal.yaw)}`]);
  const bridge = node('motor_bridge');
  if (bridge) rows.push(['Motors', WORDS[bridge.level]?.[0] ?? 'soft', bridge.message]);
  fill('motion-list', rows.length ? rows.map(([title, level, text]) => el('li', {}, el('span', { className: 'name' }, title), el('span', { className: `what ${level}` }, text))) : el('li', { className: 'soft' }, 'nothing yet'));
}

function updateLamps() {
  const lamps = (state.values.beacons?.markers ?? []).filter((each) => each.ns === 'lamps');
  const seen = lamps.filter((each) => each.color.g > each.color.r).map((each) => each.id);
  const suspect = lamps.filter((each) => each.color.r > 0.8).map((each) => each.id);
  const rows = [];
  if (lamps.length) rows.push(['Lamps', `${seen.length ? `decoded: ${seen.join(', ')}` : 'none decoded'} of ${lamps.length}`]);
  if (suspect.length) rows.push(['Suspect', `lamp ${suspect.join(', ')}`]);
  for (const command of state.commands) {
    let text = command;
    try { const each = JSON.parse(command); text = `lamp ${each.beacon}: ${each.op} ${each.value}`; } catch { /* shown as it is */ }
    rows.push(['Command', text]);
  }
  const targets = (state.values.targets?.markers ?? []).filter((each) => each.ns === 'names' && each.action === 0).map((each) => each.text);
  if (targets.length && isNew('targets')) rows.push(['Landmarks', targets.join(', ')]);
  const dots = (state.values.dots?.markers ?? []).reduce((sum, each) => sum + Math.max(each.points.length, each.action === 0 ? 1 : 0), 0);
  if (dots && isNew('dots')) rows.push(['Dots', `${dots} matched`]);
  fill('lamp-list', rows.length ? rows.map(([title, text]) => el('li', {}, el('span', { className: 'name' }, title), el('span', { className: 'what' }, text))) : el('li', { className: 'soft' }, 'none seen yet'));
}

function updateDiagnostics() {
  const box = byId('diagnostic-list');
  const all = Object.values(state.diagnostics).sort((a, b) => b.level - a.level || a.name.localeCompare(b.name));
  const isOpen = new Set([...box.querySelectorAll('details[open]')].map((each) => each.dataset.name));
  fill('diagnostic-list', all.length ? all.map((each) => {
    const isSilent = performance.now() - each.arrived > 4000;
    const [level, word] = WORDS[isSilent ? 3 : each.level] ?? WORDS[2];
    return el('details', { open: isOpen.has(each.name), 'data-name': each.name },
      el('summary', { className: level }, el('i', {}), el('b', {}, each.name.replace(/: status$/, '')), el('span', { title: each.message }, isSilent ? 'silent' : each.message), el('span', { className: 'hidden' }, word)),
      el('dl', {}, each.values.flatMap(({ key, value: text }) => [el('dt', {}, key), el('dd', {}, text)])));
  }) : el('span', { className: 'soft' }, 'no node reports'));
}

function updateState() {
  const chip = byId('state');
  const levels = Object.values(state.diagnostics).map((each) => each.level);
  const arbiter = node('pose_arbiter');
  const isSeen = robot() !== null;
  let [level, text] = ['soft', 'no robot yet'];
  if (!state.isOpen) [level, text] = ['bad', 'no connection to the server'];
  else if (state.time !== null) [level, text] = ['good', 'recorded'];
  else if (arbiter && isNew('fused')) [level, text] = [WORDS[Math.max(arbiter.level, 0)]?.[0] ?? 'weak', value(arbiter, 'state') ?? 'live'];
  else if (isNew('fused')) [level, text] = ['good', 'live'];
  else if (isSeen) [level, text] = ['weak', 'no new pose'];
  if (levels.includes(2) && state.time === null && state.isOpen && level === 'good') level = 'weak';
  chip.className = `chip ${level}`;
  chip.textContent = text;
  document.body.classList.toggle('down', !state.isOpen);
  byId('waiting').hidden = state.time === null || !state.status.progress;
  byId('waiting').textContent = `A recorded mission, until yours begins. ${state.status.progress ?? ''}`;
  byId('empty').hidden = isSeen || Boolean(state.grids.map);
  byId('progress').textContent = state.status.progress || 'Start ./shirube demo, or the nodes of your robot; this page shows them at once.';
}

export function updateRates() {
  const rates = state.status.rates ?? {};
  fill('rate-list', Object.entries(rates).sort().map(([name, count]) => el('div', {}, el('span', {}, name.replaceAll('_', ' ')), el('b', {}, `${count}/s`))));
}

export function updatePanels() {
  updatePose();
  updateSources();
  updateMotion();
  updateLamps();
  updateDiagnostics();
  updateState();
}
