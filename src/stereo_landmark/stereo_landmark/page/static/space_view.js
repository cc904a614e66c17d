// 3D view of the corresponding points with their uncertainty, the robot and its cameras.

import { el } from './dom.js';
import { ellipseOf } from './geometry.js';

const ELLIPSE_SCALES = [1, 2, 5, 10, 20, 50, 100];
const SIZE_MAX = 26;

export class SpaceView {
  /** configuration: cameras; points(): [{xyz, covariance, colour, used, name}] in the place's frame (x ahead, y left, z up). */
  constructor(configuration, points) {
    this.configuration = configuration;
    this.points = points;
    this.turn = { yaw: 0.95, pitch: 0.42 };
    this.note = el('figcaption');
    this.canvas = el('canvas', { 'data-testid': 'space', tabIndex: 0, 'aria-label': 'Points in space' });
    this.element = el('figure', { className: 'space' }, this.canvas, this.note);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  listen() {
    let last = null;
    this.canvas.addEventListener('pointerdown', (event) => {
      last = [event.clientX, event.clientY];
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      this.turn.yaw += (event.clientX - last[0]) / 150;
      this.turn.pitch = Math.min(1.55, Math.max(0.02, this.turn.pitch + (event.clientY - last[1]) / 150));
      last = [event.clientX, event.clientY];
      this.draw();
    });
    this.canvas.addEventListener('pointerup', () => { last = null; });
    this.canvas.addEventListener('dblclick', () => { this.turn = { yaw: 0.95, pitch: 0.42 }; this.draw(); });
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    const w = this.element.clientWidth, h = this.element.clientHeight;
    if (!w || !h) return;
    this.canvas.width = Math.round(w * ratio);
    this.canvas.height = Math.round(h * ratio);
    const context = this.canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, w, h);
    const points = this.points();
    this.aim(points, w, h);
    this.drawFloor(context, points);
    this.drawRobot(context);
    const factor = this.ellipseScale(points);
    for (const point of points) this.drawRay(context, point);
    for (const point of points) this.drawPoint(context, point, factor);
    this.note.textContent = points.length
      ? `3D view · ellipses show the uncertainty${factor === 1 ? '' : `, ${factor} × enlarged`} · drag to rotate`
      : '3D view: select shapes first';
  }

  /** Orthographic axes: right and up on the screen, then towards the viewer. */
  get axes() {
    const { yaw, pitch } = this.turn;
    const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return [[s, -c, 0], [c * sp, s * sp, cp], [-c * cp, -s * cp, sp]];
  }

  turned([x, y, z]) {
    return this.axes.map((row) => row[0] * x + row[1] * y + row[2] * z);
  }

  aim(points, w, h) {
    const corners = [[-0.3, -0.3, 0], [0.3, 0.3, 0], this.configuration.camera_xyz, ...points.map((p) => p.xyz),
      ...points.map((p) => [p.xyz[0], p.xyz[1], 0])].map((p) => this.turned(p));
    const low = [0, 1].map((k) => Math.min(...corners.map((p) => p[k])));
    const high = [0, 1].map((k) => Math.max(...corners.map((p) => p[k])));
    this.scale = Math.min((w - 90) / (high[0] - low[0] + 0.1), (h - 70) / (high[1] - low[1] + 0.1));
    this.offset = [w / 2 - this.scale * (low[0] + high[0]) / 2, h / 2 + 6 + this.scale * (low[1] + high[1]) / 2];
  }

  at(place) {
    const [u, v] = this.turned(place);
    return [this.offset[0] + this.scale * u, this.offset[1] - this.scale * v];
  }

  path(context, places, colour, width = 1, fill = null) {
    context.beginPath();
    places.forEach((place, i) => context[i ? 'lineTo' : 'moveTo'](...this.at(place)));
    if (fill) { context.fillStyle = fill; context.fill(); }
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
  }

  drawFloor(context, points) {
    const far = Math.ceil(Math.max(1, ...points.map((p) => p.xyz[0])) + 0.4);
    const side = Math.ceil(Math.max(1, ...points.map((p) => Math.abs(p.xyz[1]))));
    for (let y = -side; y <= side; y += 0.5) this.path(context, [[0, y, 0], [far, y, 0]], y % 1 ? '#1a3140' : '#25465a');
    for (let x = 0; x <= far; x += 0.5) this.path(context, [[x, -side, 0], [x, side, 0]], x % 1 ? '#1a3140' : '#25465a');
    context.font = '11px system-ui, sans-serif';
    context.fillStyle = '#7d9aab';
    context.textAlign = 'left';
    for (let x = 1; x <= far; x += 1) {
      const [u, v] = this.at([x, -side, 0]);
      context.fillText(`${x} m`, u + 5, v + 4);
    }
  }

  drawRobot(context) {
    const round = Array.from({ length: 37 }, (_, i) => [0.22 * Math.cos(i / 36 * 2 * Math.PI), 0.22 * Math.sin(i / 36 * 2 * Math.PI), 0]);
    this.path(context, round, '#8fb3c7', 1.5, '#16303f');
    const [x, y, z] = this.configuration.camera_xyz;
    this.path(context, [[x, y, 0], [x, y, z]], '#44657a', 2);
    for (const [axis, colour] of [[[0.45, 0, 0], '#ff6b6b'], [[0, 0.45, 0], '#69db7c'], [[0, 0, 0.45], '#74a9ff']]) {
      this.path(context, [[0, 0, 0], axis], colour, 2);
    }
    for (const shift of [0, this.configuration.baseline]) this.drawCamera(context, shift);
  }

  /** Transform a point from the left camera's optical frame to the base frame. */
  fromCamera([x, y, z]) {
    return this.configuration.camera_rotation.map((row, k) => this.configuration.camera_xyz[k] + row[0] * x + row[1] * y + row[2] * z);
  }

  drawCamera(context, shift) {
    const { width, height, focal_length: f } = this.configuration;
    const [a, b] = [0.14 * width / f / 2, 0.14 * height / f / 2];
    const corners = [[-a, -b], [a, -b], [a, b], [-a, b]].map(([x, y]) => this.fromCamera([x + shift, y, 0.14]));
    const eye = this.fromCamera([shift, 0, 0]);
    this.path(context, [...corners, corners[0]], '#d9e7ee', 1.3, '#d9e7ee22');
    corners.forEach((corner) => this.path(context, [eye, corner], '#d9e7ee', 1.3));
  }

  drawRay(context, { xyz, used }) {
    if (used) this.path(context, [this.fromCamera([0, 0, 0]), xyz], '#ffffff14');
    this.path(context, [xyz, [xyz[0], xyz[1], 0]], '#ffffff10');
  }

  /** Magnification of the uncertainty ellipses. */
  ellipseScale(points) {
    const largest = Math.max(...points.filter((p) => p.used).map((p) => 3 * p.sigma * this.scale), 1e-9);
    return ELLIPSE_SCALES.filter((factor) => factor * largest <= SIZE_MAX).at(-1) ?? 1;
  }

  drawPoint(context, { xyz, covariance, colour, used, isHovered, label }, factor) {
    const [x, y] = this.at(xyz);
    const rows = this.axes.slice(0, 2);
    const seen = rows.map((a) => rows.map((b) => a.reduce((sum, ai, i) => sum + ai * b.reduce((s, bj, j) => s + covariance[i][j] * bj, 0), 0)));
    const { long, short, turn } = ellipseOf(seen);
    const size = 3 * factor * this.scale;
    context.beginPath();
    context.ellipse(x, y, Math.max(2, long * size), Math.max(1.5, short * size), -turn, 0, 2 * Math.PI);
    context.fillStyle = used ? `${colour}44` : '#ffffff0a';
    context.fill();
    context.strokeStyle = used ? colour : '#6d8797';
    context.lineWidth = isHovered ? 2.5 : 1.2;
    context.stroke();
    context.beginPath();
    context.arc(x, y, isHovered ? 4.5 : 2.6, 0, 2 * Math.PI);
    context.fillStyle = used ? '#ffffff' : '#6d8797';
    context.fill();
    if (isHovered) {
      context.font = '600 12px system-ui, sans-serif';
      context.textAlign = 'center';
      context.fillText(label, x, y - 12);
    }
  }
}
