// One camera image on a canvas, with overlays.

import { el } from './dom.js';

/** Viewport shared by all pictures: zoom and centre (as fractions of the image). */
export const viewport = { zoom: 1, x: 0.5, y: 0.5 };
const ZOOM_MAX = 12;

export class PictureView {
  /** width, height: of the image [px]; paint(pen): draws over it; pointer: handlers down, move, up, leave. */
  constructor({ title, testid, width, height, paint, pointer = {}, onViewportChange }) {
    Object.assign(this, { width, height, paint, pointer, onViewportChange });
    this.canvas = el('canvas', { 'data-testid': testid, tabIndex: 0, 'aria-label': title });
    this.element = el('figure', {}, this.canvas, el('figcaption', {}, title));
    this.image = null;
    this.dim = 1;
    this.pan = null;
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  show(url) {
    if (this.url === url) return;
    this.url = url;
    const image = new Image();
    image.onload = () => { this.image = image; this.draw(); };
    image.src = url;
  }

  /** Scale and offset from image to canvas, in CSS pixels. */
  get placing() {
    const { clientWidth: w, clientHeight: h } = this.element;
    const scale = Math.min(w / this.width, h / this.height) * viewport.zoom;
    return { scale, x: w / 2 - viewport.x * this.width * scale, y: h / 2 - viewport.y * this.height * scale };
  }

  placeOf(event) {
    const box = this.canvas.getBoundingClientRect();
    const { scale, x, y } = this.placing;
    return [(event.clientX - box.left - x) / scale - 0.5, (event.clientY - box.top - y) / scale - 0.5];
  }

  /** Position of an image point on the browser's page, for tests. */
  onPage([u, v]) {
    const box = this.canvas.getBoundingClientRect();
    const { scale, x, y } = this.placing;
    return [box.left + x + (u + 0.5) * scale, box.top + y + (v + 0.5) * scale];
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      const before = this.placeOf(event);
      viewport.zoom = Math.min(ZOOM_MAX, Math.max(1, viewport.zoom * Math.exp(-event.deltaY / 400)));
      const after = this.placeOf(event);
      moveViewport((before[0] - after[0]) / this.width, (before[1] - after[1]) / this.height);
      this.onViewportChange();
    }, { passive: false });
    const fingers = new Map();
    canvas.addEventListener('pointerdown', (event) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      if (event.pointerType === 'touch') fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (fingers.size > 1) { this.pointer.cancel?.(); return; }
      if (event.button === 1 || event.button === 2 || event.altKey) {
        this.pan = [event.clientX, event.clientY];
        event.preventDefault();
      } else if (event.button === 0) this.pointer.down?.(this.placeOf(event), event);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (fingers.size > 1) { this.pinch(fingers, event); return; }
      if (!this.pan) { this.pointer.move?.(this.placeOf(event), event, this); return; }
      const { scale } = this.placing;
      moveViewport(-(event.clientX - this.pan[0]) / scale / this.width, -(event.clientY - this.pan[1]) / scale / this.height);
      this.pan = [event.clientX, event.clientY];
      this.onViewportChange();
    });
    const lift = (event) => fingers.delete(event.pointerId) && fingers.size > 0;
    canvas.addEventListener('pointercancel', lift);
    canvas.addEventListener('pointerup', (event) => {
      if (lift(event)) return;
      if (this.pan) { this.pan = null; return; }
      this.pointer.up?.(this.placeOf(event), event);
    });
    canvas.addEventListener('pointerleave', () => this.pointer.leave?.());
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  /** Two fingers move and zoom the pictures. */
  pinch(fingers, event) {
    const spread = () => { const [a, b] = [...fingers.values()]; return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], length: Math.hypot(a[0] - b[0], a[1] - b[1]) }; };
    const before = spread();
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    const after = spread();
    const { scale } = this.placing;
    zoomViewport(after.length / Math.max(before.length, 1));
    moveViewport(-(after.middle[0] - before.middle[0]) / scale / this.width, -(after.middle[1] - before.middle[1]) / scale / this.height);
    this.onViewportChange();
  }

  draw() {
    const { canvas, element } = this;
    const ratio = window.devicePixelRatio || 1;
    const w = element.clientWidth, h = element.clientHeight;
    if (!w || !h) return;
    if (canvas.width !== Math.round(w * ratio) || canvas.height !== Math.round(h * ratio)) {
      canvas.width = Math.round(w * ratio);
      canvas.height = Math.round(h * ratio);
    }
    const context = canvas.getContext('2d');
    const { scale, x, y } = this.placing;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, w, h);
    context.save();
    context.beginPath();
    context.rect(x, y, this.width * scale, this.height * scale);
    context.clip();
    context.imageSmoothingEnabled = scale < 3;
    if (this.image) {
      context.globalAlpha = this.dim;
      context.drawImage(this.image, x, y, this.width * scale, this.height * scale);
      context.globalAlpha = 1;
    }
    this.paint?.(new Pen(context, scale, x, y));
    context.restore();
  }
}

/** Colour of a segment, constant while its start point does not move. */
const colourOfPlace = (u, v) => `hsl(${(Math.round(u / 64) * 137.5 + Math.round(v / 64) * 59.3) % 360} 90% 66%)`;

function moveViewport(x, y) {
  // Limited so that the image covers the centre.
  const room = 0.5 / viewport.zoom;
  viewport.x = Math.min(1 - room, Math.max(room, viewport.x + x));
  viewport.y = Math.min(1 - room, Math.max(room, viewport.y + y));
}

export function resetViewport() {
  Object.assign(viewport, { zoom: 1, x: 0.5, y: 0.5 });
}

export function zoomViewport(factor) {
  viewport.zoom = Math.min(ZOOM_MAX, Math.max(1, viewport.zoom * factor));
  moveViewport(0, 0);
}

/** Draws in pixels of the image; line widths are those of the screen. The centre of the first pixel is (0, 0). */
class Pen {
  constructor(context, scale, x, y) {
    // Marks are smaller on small pictures.
    const mark = Math.min(1, Math.max(0.5, context.canvas.clientWidth / 420));
    Object.assign(this, { context, scale, x, y, mark });
  }

  at([u, v]) {
    return [this.x + (u + 0.5) * this.scale, this.y + (v + 0.5) * this.scale];
  }

  lines(lines, colour, width = 1.5, { glow = false, dash = [], fill = null } = {}) {
    const { context } = this;
    context.beginPath();
    for (const line of lines) line.forEach((place, i) => context[i ? 'lineTo' : 'moveTo'](...this.at(place)));
    context.setLineDash(dash);
    context.lineJoin = 'round';
    if (fill) { context.fillStyle = fill; context.fill(); }
    if (glow) { context.strokeStyle = 'rgba(4, 12, 18, 0.75)'; context.lineWidth = width + 3; context.stroke(); }
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
    context.setLineDash([]);
  }

  /** Edge points as {points: Int16Array, starts: Int32Array, unit}; each segment in its own colour. */
  edges({ points, starts, unit }) {
    const { context } = this;
    context.lineWidth = Math.min(2, Math.max(1.1, 0.6 * this.scale));
    for (let s = 0; s + 1 < starts.length; s += 1) {
      context.beginPath();
      for (let i = starts[s]; i < starts[s + 1]; i += 1) {
        const [u, v] = this.at([points[2 * i] / unit, points[2 * i + 1] / unit]);
        if (i === starts[s]) context.moveTo(u, v);
        else context.lineTo(u, v);
      }
      context.strokeStyle = colourOfPlace(points[2 * starts[s]], points[2 * starts[s] + 1]);
      context.stroke();
    }
  }

  cross(place, colour, size = 6, width = 2) {
    const [x, y] = this.at(place);
    const { context } = this;
    size *= this.mark;
    for (const [style, w] of [['rgba(4, 12, 18, 0.8)', this.mark * (width + 2.5)], [colour, this.mark * width]]) {
      context.beginPath();
      context.moveTo(x - size, y); context.lineTo(x + size, y);
      context.moveTo(x, y - size); context.lineTo(x, y + size);
      context.strokeStyle = style;
      context.lineWidth = w;
      context.stroke();
    }
  }

  ring(place, colour, size = 9, width = 2) {
    const { context } = this;
    context.beginPath();
    context.arc(...this.at(place), size, 0, 2 * Math.PI);
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke();
  }

  badge(place, text, colour, ink = '#06131b') {
    const { context } = this;
    const [x, y] = this.at(place);
    context.font = '600 12px system-ui, sans-serif';
    const w = Math.max(20, context.measureText(text).width + 11);
    context.beginPath();
    context.roundRect(x - w / 2, y - 10, w, 20, 10);
    context.fillStyle = colour;
    context.fill();
    context.strokeStyle = 'rgba(4, 12, 18, 0.7)';
    context.lineWidth = 1.5;
    context.stroke();
    context.fillStyle = ink;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    context.fillText(text, x, y + 0.5);
  }

  /** Darken all but a rectangle [left, top, right, bottom]. */
  spotlight([left, top, right, bottom]) {
    const { context } = this;
    const [x0, y0] = this.at([left, top]), [x1, y1] = this.at([right, bottom]);
    context.beginPath();
    context.rect(-1e4, -1e4, 2e4, 2e4);
    context.rect(x0, y0, x1 - x0, y1 - y0);
    context.fillStyle = 'rgba(4, 12, 18, 0.55)';
    context.fill('evenodd');
    context.setLineDash([6, 4]);
    context.strokeStyle = '#ffffffcc';
    context.lineWidth = 1.5;
    context.strokeRect(x0, y0, x1 - x0, y1 - y0);
    context.setLineDash([]);
  }
}
