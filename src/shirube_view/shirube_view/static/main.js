// The live page: connection, header, tools, time line, keys.

import { Connection } from './connection.js';
import { byId, el, toast } from './dom.js';
import { letGo, listenToStick } from './drive.js';
import { choose, fit, follow, move, onPage, redraw, refit, tool, zoom } from './map_view.js';
import { updatePanels, updateRates } from './panels.js';
import { SOURCES, clear, robot, state, take } from './state.js';

const PANEL_PERIOD = 200; // [ms]
const looked = new Set();
let isSeeking = false;
let queue = Promise.resolve();
let received = 0;

const connection = new Connection({
  onConnection(isOpen) {
    state.isOpen = isOpen;
    if (!isOpen) letGo();
    else connectionOpened();
  },
  onMessage(message) {
    received += 1;
    // Grids are inflated asynchronously; messages keep their order.
    queue = queue.then(() => receive(message)).catch((fault) => console.error(fault));
  },
  async onPicture(index, blob) {
    const name = state.hello?.pictures[index];
    const canvas = name && document.querySelector(`canvas[data-picture="${CSS.escape(name)}"]`);
    if (!canvas) return;
    const bitmap = await createImageBitmap(blob);
    Object.assign(canvas, { width: bitmap.width, height: bitmap.height });
    canvas.getContext('2d').drawImage(bitmap, 0, 0);
    bitmap.close();
    canvas.dataset.count = String(Number(canvas.dataset.count ?? 0) + 1);
  },
});

function connectionOpened() {
  if (looked.size) connection.send('look', { pictures: [...looked] });
}

async function receive(message) {
  if (message.said) toast(message.said);
  if (message.error) toast(message.error, true);
  if (message.cleared) { clear(); refit(); }
  if (message.hello) greet(message.hello);
  if (message.live) { byId('source').value = String(state.hello.bags.length); state.time = null; toast('The robot is live now.'); }
  if (message.status) showStatus(message.status);
  if (message.time !== undefined) { state.time = message.time; showClock(); }
  if (message.values) { await take(message.values); redraw(); }
}

function greet(hello) {
  state.hello = hello;
  document.body.classList.toggle('watching', !hello.may_command);
  byId('source').replaceChildren(el('option', { value: hello.bags.length }, 'Live'), ...hello.bags.map((name, i) => el('option', { value: i }, name)));
  byId('source').value = hello.bags.length ? '0' : String(hello.bags.length);
  byId('picture-buttons').replaceChildren(...hello.pictures.map((name) => el('button', {
    'data-testid': `look-${name}`, 'aria-pressed': String(looked.has(name)), onclick: (event) => look(name, event.currentTarget),
  }, name.replace(' picture', ''))));
}

function look(name, button) {
  if (looked.delete(name)) document.querySelector(`figure[data-picture="${CSS.escape(name)}"]`)?.remove();
  else {
    looked.add(name);
    byId('pictures').append(el('figure', { 'data-picture': name }, el('canvas', { 'data-picture': name, role: 'img', 'aria-label': name }), el('figcaption', {}, name)));
  }
  button.setAttribute('aria-pressed', String(looked.has(name)));
  connection.send('look', { pictures: [...looked] });
}

function showStatus(status) {
  state.status = status;
  const isRecorded = status.length !== null;
  byId('timeline').hidden = !isRecorded;
  document.body.classList.toggle('recorded', isRecorded);
  if (!isRecorded) state.time = null;
  byId('seek').max = String(status.length ?? 1);
  byId('simulation').hidden = !status.is_simulated || isRecorded;
  byId('record').setAttribute('aria-pressed', String(status.is_recording));
  byId('record').textContent = status.is_recording ? 'Stop recording' : 'Record a bag';
  updateRates();
}

function showClock() {
  const total = state.status.length ?? 0;
  if (!isSeeking) byId('seek').value = String(state.time);
  byId('clock').textContent = `${state.time.toFixed(1)} of ${total.toFixed(1)} s`;
}

// Tools of the map.

const HINTS = {
  goal: 'Press where the robot shall go, drag to where it shall look.', initialpose: 'Press where the robot is, drag to where it looks.',
  kidnap: 'Press where the robot shall be put.', obstacle: 'Press where the obstacle shall be.', walker: 'Press where the person starts, drag to where it goes.',
};

function use(name, onChosen) {
  const isOff = tool() === name;
  choose(isOff ? null : name, (place) => { use(null); onChosen(place); });
  for (const button of document.querySelectorAll('[data-tool], #goal, #initialpose')) button.setAttribute('aria-pressed', String(!isOff && (button.id || button.dataset.tool) === name));
  byId('hint').hidden = isOff || !name;
  byId('hint').textContent = HINTS[name] ?? '';
}

const useGoal = () => use('goal', (place) => connection.send('goal', place));
const useInitial = () => use('initialpose', (place) => connection.send('initialpose', place));
const cancel = () => connection.send('call', { name: 'cancel' });

function stop() {
  letGo();
  if (!connection.send('stop')) { toast('no connection: the stop was not sent', true); return; }
  byId('stop').classList.add('on');
  byId('release').hidden = false;
}

byId('stop').onclick = stop;
byId('release').onclick = () => {
  connection.send('release');
  byId('stop').classList.remove('on');
  byId('release').hidden = true;
};
byId('goal').onclick = useGoal;
byId('initialpose').onclick = useInitial;
byId('cancel').onclick = cancel;
byId('in').onclick = () => zoom(1.4);
byId('out').onclick = () => zoom(1 / 1.4);
byId('fit').onclick = () => { follow(false); fit(); };
byId('follow').onclick = () => follow();
byId('help').onclick = () => byId('keys').showModal();
byId('record').onclick = () => connection.send('record');
byId('teach').href = `${location.protocol}//${location.hostname}:8765/`;
for (const button of document.querySelectorAll('[data-call]')) {
  button.onclick = () => {
    const isSure = button.dataset.call !== 'clear_map' || window.confirm('Clear the map? It cannot be brought back.');
    if (isSure) connection.send('call', { name: button.dataset.call });
  };
}

// Simulation.

const isOn = {};
function toggle(key, fields, title) {
  const button = el('button', { 'aria-pressed': 'false', onclick: () => {
    isOn[key] = !isOn[key];
    button.setAttribute('aria-pressed', String(isOn[key]));
    connection.send('simulate', { ...fields, on: isOn[key] });
  } }, title);
  return button;
}
const placing = (what, title) => el('button', { 'data-tool': what, 'aria-pressed': 'false', onclick: () => use(what, (place) => connection.send('simulate', { what, ...place })) }, title);
byId('simulation-buttons').append(
  toggle('floor', { what: 'cover', camera: 'floor' }, 'Cover floor camera'), toggle('ceiling', { what: 'cover', camera: 'ceiling' }, 'Cover ceiling camera'),
  toggle('stereo', { what: 'cover', camera: 'stereo' }, 'Cover stereo cameras'), toggle('depth', { what: 'cover', camera: 'depth' }, 'Cover depth camera'),
  toggle('lamps', { what: 'lamps' }, 'Lamps off'), placing('kidnap', 'Kidnap the robot'), placing('obstacle', 'Put an obstacle'), placing('walker', 'Send a walker'),
  el('button', { onclick: () => connection.send('simulate', { what: 'clear' }) }, 'Remove what was put'),
);

// Time line.

const speed = () => Number(byId('speed').value);
const isPlaying = () => state.status.speed > 0;
function play(value) {
  state.status.speed = value;
  connection.send('speed', { speed: value });
  byId('play').textContent = value > 0 ? '❚❚' : '▶';
  byId('play').setAttribute('aria-label', value > 0 ? 'Pause' : 'Play');
}
byId('source').onchange = (event) => {
  state.time = null;
  play(speed());
  connection.send('source', { bag: Number(event.target.value) });
};
byId('play').onclick = () => play(isPlaying() ? 0 : speed());
byId('speed').onchange = () => play(speed());
byId('seek').addEventListener('pointerdown', () => { isSeeking = true; });
byId('seek').addEventListener('input', (event) => { byId('clock').textContent = `${Number(event.target.value).toFixed(1)} s`; });
byId('seek').addEventListener('change', (event) => { isSeeking = false; connection.send('seek', { time: Number(event.target.value) }); });

// Keys.

document.addEventListener('keydown', (event) => {
  if (event.target.matches('input, select, dialog *') || event.ctrlKey || event.metaKey || event.altKey) return;
  const may = state.hello?.may_command && state.time === null;
  const action = {
    Space: may && stop, KeyG: may && useGoal, KeyI: may && useInitial, KeyC: may && cancel, Escape: () => use(null), Equal: () => zoom(1.4), NumpadAdd: () => zoom(1.4), Minus: () => zoom(1 / 1.4),
    Digit0: () => { follow(false); fit(); }, KeyF: () => follow(), KeyK: () => { if (state.time !== null) byId('play').click(); },
  }[event.code];
  if (event.key === '?') byId('keys').showModal();
  if (!action) return;
  event.preventDefault();
  action();
});

byId('legend').replaceChildren(...[['robot', 'fused pose'], ...Object.entries(SOURCES).map(([name, title]) => [name, title.toLowerCase()]), ['plan', 'plan'], ['person', 'people'], ['bad', 'stop zone'], ['truth', 'truth']].map(([name, title]) => {
  const dot = el('i', {});
  dot.style.background = `var(--${name})`;
  return el('span', {}, dot, title);
}));
listenToStick(connection);
setInterval(() => { if (!document.hidden) updatePanels(); }, PANEL_PERIOD);
document.addEventListener('visibilitychange', redraw);
window.__view = { state, robot, onPage, received: () => received };
