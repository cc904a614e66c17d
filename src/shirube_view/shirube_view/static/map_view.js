// The map on a canvas: grids, zones, poses, plan, people; pan, zoom, and places chosen by pointer.

import { byId, colour, yawOf } from './dom.js';
import { SOURCES, poseOf, robot, state } from './state.js';

const canvas = byId('map');
const context = canvas.getContext('2d');
const view = { x: 0, y: 0, scale: 60, isFollowing: true, hasFitted: false };
const aim = { tool: null, start: null, end: null, onChosen: null };
const pointers = new Map();
let colours = {};
let isDirty = true;

export const ROBOT_RADIUS = 0.2;
const OLD = 1.0; // a fix older than this is drawn pale [s]

export const redraw = () => { isDirty = true; };
const toPage = (x, y) => [canvas.clientWidth / 2 + (x - view.x) * view.scale, canvas.clientHeight / 2 - (y - view.y) * view.scale];
const toMap = (px, py) => [view.x + (px - canvas.clientWidth / 2) / view.scale, view.y - (py - canvas.clientHeight / 2) / view.scale];

function readColours() {
  for (const name of ['unknown', 'free', 'wall', 'plan', 'robot', 'person', 'truth', 'ink', 'soft', 'accent', 'bad', 'weak', 'good', 'panel', ...Object.keys(SOURCES)]) colours[name] = colour(name);
  for (const grid of Object.values(state.grids)) grid.picture = null;
  redraw();
}
matchMedia('(prefers-color-scheme: light)').addEventListener('change', readColours);

function rgb(text) {
  const number = parseInt(text.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

function pictureOf(grid, isLocal) {
  if (grid.picture) return grid.picture;
  const picture = document.createElement('canvas');
  picture.width = grid.width;
  picture.height = grid.height;
  const image = new ImageData(grid.width, grid.height);
  const pixels = new Uint32Array(image.data.buffer);
  const table = new Uint32Array(256);
  const bytes = new Uint8ClampedArray(table.buffer);
  const [free, wall, hot] = ['free', 'wall', 'weak'].map((name) => rgb(colours[name]));
  for (let value = 0; value <= 100; value += 1) {
    const share = value / 100;
    const to = isLocal ? hot : wall;
    for (let c = 0; c < 3; c += 1) bytes[4 * value + c] = free[c] + share * (to[c] - free[c]);
    bytes[4 * value + 3] = isLocal ? (value >= 50 ? 210 : 0) : 255;
  }
  for (let r = 0; r < grid.height; r += 1) {
    const from = (grid.height - 1 - r) * grid.width; // images begin at the top
    for (let c = 0; c < grid.width; c += 1) pixels[r * grid.width + c] = table[grid.cells[from + c] & 255];
  }
  picture.getContext('2d').putImageData(image, 0, 0);
  grid.picture = picture;
  return picture;
}

function bounds() {
  const { map } = state.grids;
  if (map) return [map.origin[0], map.origin[1], map.origin[0] + map.width * map.resolution, map.origin[1] + map.height * map.resolution];
  const at = robot();
  return at ? [at.x - 3, at.y - 3, at.x + 3, at.y + 3] : null;
}

export function fit() {
  const box = bounds();
  if (!box) return;
  const [x0, y0, x1, y1] = box;
  Object.assign(view, { x: (x0 + x1) / 2, y: (y0 + y1) / 2 });
  view.scale = Math.min(400, 0.9 * Math.min(canvas.clientWidth / (x1 - x0), canvas.clientHeight / (y1 - y0)));
  redraw();
}

export function zoom(factor, at = [canvas.clientWidth / 2, canvas.clientHeight / 2]) {
  const [x, y] = toMap(...at);
  view.scale = Math.min(2000, Math.max(4, view.scale * factor));
  const [nx, ny] = toMap(...at);
  view.x += x - nx;
  view.y += y - ny;
  redraw();
}

export function move(dx, dy) {
  follow(false);
  view.x -= dx / view.scale;
  view.y += dy / view.scale;
  redraw();
}

export function follow(isOn = !view.isFollowing) {
  view.isFollowing = isOn;
  byId('follow').setAttribute('aria-pressed', String(isOn));
  redraw();
}

/** Let the user choose a pose; onChosen({ x, y, yaw }). */
export function choose(tool, onChosen) {
  Object.assign(aim, { tool, onChosen, start: null, end: null });
  canvas.classList.toggle('aiming', Boolean(tool));
  redraw();
}
export const tool = () => aim.tool;

function line(points, style, width, dash = []) {
  if (points.length < 2) return;
  context.beginPath();
  points.forEach(([x, y], i) => { const [px, py] = toPage(x, y); if (i) context.lineTo(px, py); else context.moveTo(px, py); });
  context.setLineDash(dash);
  context.strokeStyle = style;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

/** Ellipse of 95 % from the covariance of x and y. */
function ellipse(pose, covariance, style) {
  const [xx, xy, yy] = [covariance[0], covariance[1], covariance[7]];
  if ([xx, xy, yy].includes(null)) return;
  const [mean, half] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
  const [a, b] = [mean + half, Math.max(mean - half, 0)].map((variance) => Math.sqrt(5.991 * variance) * view.scale);
  const [px, py] = toPage(pose.x, pose.y);
  context.beginPath();
  context.ellipse(px, py, Math.max(a, 0.5), Math.max(b, 0.5), -0.5 * Math.atan2(2 * xy, xx - yy), 0, 2 * Math.PI);
  context.globalAlpha = 0.25;
  context.fillStyle = style;
  context.fill();
  context.globalAlpha = 1;
  context.strokeStyle = style;
  context.lineWidth = 1.5;
  context.stroke();
}

function arrow(pose, size, style, width = 2.5) {
  const [px, py] = toPage(pose.x, pose.y);
  context.save();
  context.translate(px, py);
  context.rotate(-pose.yaw);
  context.beginPath();
  context.moveTo(-size * 0.5, 0);
  context.lineTo(size, 0);
  context.moveTo(size * 0.55, -size * 0.35);
  context.lineTo(size, 0);
  context.lineTo(size * 0.55, size * 0.35);
  context.strokeStyle = style;
  context.lineWidth = width;
  context.lineCap = 'round';
  context.stroke();
  context.restore();
}

function disc(x, y, radius, style, alpha = 1, isStroke = false) {
  const [px, py] = toPage(x, y);
  context.beginPath();
  context.arc(px, py, Math.max(1.5, radius), 0, 2 * Math.PI);
  context.globalAlpha = alpha;
  if (isStroke) { context.strokeStyle = style; context.lineWidth = 2; context.stroke(); } else { context.fillStyle = style; context.fill(); }
  context.globalAlpha = 1;
}

function label(text, x, y, style) {
  const [px, py] = toPage(x, y);
  context.font = '600 12px system-ui, sans-serif';
  context.textAlign = 'center';
  context.lineWidth = 3;
  context.strokeStyle = colours.panel;
  context.strokeText(text, px, py);
  context.fillStyle = style;
  context.fillText(text, px, py);
}

function grid(name) {
  const each = state.grids[name];
  if (!each) return;
  context.imageSmoothingEnabled = false;
  const [px, py] = toPage(each.origin[0], each.origin[1] + each.height * each.resolution);
  const side = each.resolution * view.scale;
  context.drawImage(pictureOf(each, name === 'local_map'), px, py, each.width * side, each.height * side);
}

/** Points of a marker in the map; markers in the robot's or a camera's frame are placed at the robot. */
function inMap(header, points, at) {
  if (header.frame_id === 'map') return points.map((p) => [p.x, p.y]);
  if (!at) return [];
  const [c, s] = [Math.cos(at.yaw), Math.sin(at.yaw)];
  return points.map((p) => [at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y]);
}

function markers(name, at, style) {
  for (const marker of state.values[name]?.markers ?? []) {
    if (marker.action !== 0) continue;
    const own = [marker.pose.position, ...marker.points].slice(marker.points.length ? 1 : 0);
    const places = inMap(marker.header, own, at);
    const { r, g, b } = marker.color;
    const paint = style ?? `rgb(${255 * r} ${255 * g} ${255 * b})`;
    for (const [x, y] of places) {
      if (marker.type === 9) label(marker.text, x, y, colours.ink);
      else disc(x, y, Math.min(12, Math.max(2.5, 0.5 * marker.scale.x * view.scale)), paint, 0.9);
    }
  }
}

function zone(name, at, style) {
  const value = state.values[name];
  if (!value || !at || performance.now() - state.arrived[name] > 1500) return;
  const points = inMap(value.header, value.polygon.points, at);
  if (points.length < 3) return;
  context.beginPath();
  points.forEach(([x, y], i) => { const [px, py] = toPage(x, y); if (i) context.lineTo(px, py); else context.moveTo(px, py); });
  context.closePath();
  context.globalAlpha = 0.13;
  context.fillStyle = style;
  context.fill();
  context.globalAlpha = 0.8;
  context.strokeStyle = style;
  context.lineWidth = 1;
  context.stroke();
  context.globalAlpha = 1;
}

function people(at) {
  for (const marker of state.values.people?.markers ?? []) {
    if (marker.action !== 0) continue;
    const [[x, y]] = inMap(marker.header, [marker.pose.position], at);
    if (marker.type === 0) arrow({ x, y, yaw: yawOf(marker.pose.orientation) }, marker.scale.x * view.scale, colours.person, 3);
    else { disc(x, y, 0.5 * marker.scale.x * view.scale, colours.person, 0.45); disc(x, y, 0.5 * marker.scale.x * view.scale, colours.person, 1, true); }
  }
}

function drawRobot(at) {
  const [px, py] = toPage(at.x, at.y);
  const radius = Math.max(7, ROBOT_RADIUS * view.scale);
  disc(at.x, at.y, radius, colours.robot, 0.35);
  disc(at.x, at.y, radius, colours.robot, 1, true);
  context.save();
  context.translate(px, py);
  context.rotate(-at.yaw);
  context.beginPath();
  context.moveTo(radius * 0.85, 0);
  context.lineTo(-radius * 0.45, -radius * 0.5);
  context.lineTo(-radius * 0.2, 0);
  context.lineTo(-radius * 0.45, radius * 0.5);
  context.closePath();
  context.fillStyle = colours.robot;
  context.fill();
  context.restore();
}

function drawScale() {
  const choices = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
  const step = choices.find((each) => each * view.scale > 50) ?? 100;
  const [x, y, width] = [canvas.clientWidth - 14, canvas.clientHeight - 14, step * view.scale];
  context.strokeStyle = colours.ink;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(x - width, y);
  context.lineTo(x, y);
  context.stroke();
  context.font = '12px system-ui, sans-serif';
  context.textAlign = 'right';
  context.fillStyle = colours.ink;
  context.fillText(step < 1 ? `${100 * step} cm` : `${step} m`, x, y - 6);
}

function draw() {
  requestAnimationFrame(draw);
  if (!isDirty || document.hidden) return;
  isDirty = false;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colours.unknown;
  context.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  const at = robot();
  if (!view.hasFitted && bounds()) { view.hasFitted = true; fit(); }
  if (view.isFollowing && at) Object.assign(view, { x: at.x, y: at.y });
  grid('map');
  grid('local_map');
  zone('slow_zone', at, colours.weak);
  zone('stop_zone', at, colours.bad);
  line(state.truthTrack.map((p) => [p.x, p.y]), colours.truth, 1, [2, 4]);
  line(state.track.map((p) => [p.x, p.y]), colours.robot, 1.5);
  line((state.values.plan?.poses ?? []).map((p) => [p.pose.position.x, p.pose.position.y]), colours.plan, 3, [8, 5]);
  const goal = poseOf(state.values.goal);
  if (goal) { disc(goal.x, goal.y, 9, colours.accent, 1, true); arrow(goal, 18, colours.accent); }
  const waypoint = poseOf(state.values.waypoint);
  if (waypoint) disc(waypoint.x, waypoint.y, 4, colours.plan);
  markers('beacons', at);
  markers('targets', at);
  markers('dots', at, colours.floor_localizer);
  people(at);
  const newest = at?.stamp ?? 0;
  for (const name of Object.keys(SOURCES)) {
    const pose = poseOf(state.values[name]);
    if (!pose) continue;
    context.globalAlpha = 1;
    const isOld = newest - pose.stamp > OLD;
    if (!isOld) ellipse(pose, state.values[name].pose.covariance, colours[name]);
    if (!isOld) arrow(pose, 16, colours[name]); else disc(pose.x, pose.y, 3.5, colours[name], 0.5);
  }
  if (at) {
    drawRobot(at);
    if (state.values.fused) ellipse(at, state.values.fused.pose.covariance, colours.robot);
  }
  if (aim.start) {
    const yaw = aimYaw();
    disc(aim.start[0], aim.start[1], 11, colours.accent, 1, true);
    arrow({ x: aim.start[0], y: aim.start[1], yaw }, 42, colours.accent, 4);
  }
  drawScale();
}

const aimYaw = () => (Math.hypot(aim.end[0] - aim.start[0], aim.end[1] - aim.start[1]) * view.scale < 8 ? (robot()?.yaw ?? 0) : Math.atan2(aim.end[1] - aim.start[1], aim.end[0] - aim.start[0]));

canvas.addEventListener('pointerdown', (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  if (aim.tool && pointers.size === 1) { aim.start = toMap(event.offsetX, event.offsetY); aim.end = aim.start; follow(false); }
  redraw();
});
canvas.addEventListener('pointermove', (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const now = [event.offsetX, event.offsetY];
  const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
  if (aim.start) aim.end = toMap(...now);
  else if (others.length) {
    const [other] = others;
    const gap = (p) => Math.max(20, Math.hypot(p[0] - other[0], p[1] - other[1]));
    zoom(gap(now) / gap(before), other);
  } else move(now[0] - before[0], now[1] - before[1]);
  pointers.set(event.pointerId, now);
  redraw();
});
canvas.addEventListener('pointerup', (event) => {
  pointers.delete(event.pointerId);
  if (!aim.start) return;
  const chosen = { x: aim.start[0], y: aim.start[1], yaw: aimYaw() };
  const { onChosen } = aim;
  choose(null);
  onChosen(chosen);
});
canvas.addEventListener('pointercancel', (event) => { pointers.delete(event.pointerId); aim.start = null; redraw(); });
canvas.addEventListener('wheel', (event) => { event.preventDefault(); zoom(Math.exp(-0.0015 * event.deltaY), [event.offsetX, event.offsetY]); }, { passive: false });
canvas.addEventListener('keydown', (event) => {
  const step = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] }[event.key];
  if (step) { event.preventDefault(); move(...step); }
});
new ResizeObserver(redraw).observe(canvas);
readColours();
draw();

export const onPage = (x, y) => { const box = canvas.getBoundingClientRect(); const [px, py] = toPage(x, y); return [box.left + px, box.top + py]; };
export const refit = () => { view.hasFitted = false; redraw(); };
