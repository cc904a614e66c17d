// Dead man's switch: commands are sent only while the stick or a key is held; silence stops the robot on the server.

import { byId } from './dom.js';

const PERIOD = 70; // of the heartbeat [ms]; the server stops the robot after 200 ms of silence
const KEYS = {
  ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1], KeyD: [0, -1],
};
const stick = byId('stick');
const knob = stick.firstElementChild;
const held = new Set();
let connection = null;
let timer = 0;
let velocity = [0, 0];

function show() {
  const reach = stick.clientWidth / 2 - 20;
  knob.style.transform = `translate(${-velocity[1] * reach}px, ${-velocity[0] * reach}px)`;
  stick.classList.toggle('on', Boolean(timer));
}

function send(isFirst) {
  connection.send('drive', { forward: velocity[0], turn: velocity[1], first: isFirst });
}

function hold(forward, turn) {
  velocity = [forward, turn].map((each) => Math.max(-1, Math.min(1, each)));
  if (!timer) {
    timer = setInterval(() => send(false), PERIOD);
    send(true);
  }
  show();
}

export function letGo() {
  if (!timer) return;
  clearInterval(timer);
  timer = 0;
  held.clear();
  velocity = [0, 0];
  connection.send('let_go');
  show();
}

function holdKeys() {
  if (!held.size) { letGo(); return; }
  const sum = [...held].map((code) => KEYS[code]).reduce(([a, b], [c, d]) => [a + c, b + d], [0, 0]);
  hold(...sum);
}

export function listenToStick(to) {
  connection = to;
  const place = (event) => {
    const box = stick.getBoundingClientRect();
    const reach = box.width / 2 - 20;
    let [x, y] = [(event.clientX - box.left - box.width / 2) / reach, (event.clientY - box.top - box.height / 2) / reach];
    const far = Math.hypot(x, y);
    if (far > 1) [x, y] = [x / far, y / far];
    hold(-y, -x);
  };
  stick.addEventListener('pointerdown', (event) => { stick.setPointerCapture(event.pointerId); stick.focus(); place(event); });
  stick.addEventListener('pointermove', (event) => { if (stick.hasPointerCapture(event.pointerId)) place(event); });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) stick.addEventListener(end, letGo);
  stick.addEventListener('contextmenu', (event) => event.preventDefault());
  stick.addEventListener('keydown', (event) => {
    if (!(event.code in KEYS)) return;
    event.preventDefault();
    held.add(event.code);
    holdKeys();
  });
  stick.addEventListener('keyup', (event) => { if (held.delete(event.code)) holdKeys(); });
  stick.addEventListener('blur', letGo);
  window.addEventListener('blur', letGo);
  window.addEventListener('pagehide', letGo);
  document.addEventListener('visibilitychange', () => { if (document.hidden) letGo(); });
}
