// Helpers that create page elements.

/** Create an element: attributes, on… handlers and properties by name, then children or strings. */
export function el(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name === 'style') Object.assign(made.style, value);
    else if (name in made && name !== 'list') made[name] = value;
    else made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

/** Create an SVG element. */
export function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

export const byId = (id) => document.getElementById(id);

/** The colour of each kind of primitive. */
export const COLOURS = {
  ellipse: '#4cc9f0', quadrilateral: '#ffb703', parallel_lines: '#c79bff', corner: '#7ae582',
};
export const KIND_NAMES = {
  ellipse: 'Ellipse', quadrilateral: 'Quadrilateral', parallel_lines: 'Parallel lines', corner: 'Corner',
};
export const KIND_KEYS = { ellipse: 'e', quadrilateral: 'q', parallel_lines: 'l', corner: 'c' };
const KIND_PATHS = {
  ellipse: 'M2 8a6 4.6 0 1 0 12 0a6 4.6 0 1 0 -12 0', quadrilateral: 'M2.5 4.5 13 3 13.5 12.5 3 13Z',
  parallel_lines: 'M2 5.5 14 3.5M2 12.5 14 10.5', corner: 'M3 2.5V13H13.5',
};

/** Icon of a kind. */
export function kindIcon(kind) {
  const path = svg('path', { d: KIND_PATHS[kind], fill: 'none', stroke: COLOURS[kind], 'stroke-width': 1.8 });
  return svg('svg', { viewBox: '0 0 16 16', width: 16, height: 16, class: 'kind' }, path);
}

let hiding = 0;

/** Show a message for some seconds. */
export function toast(text, isFault = false) {
  const box = byId('toast');
  box.textContent = text;
  box.className = isFault ? 'fault' : '';
  box.hidden = false;
  clearTimeout(hiding);
  hiding = setTimeout(() => { box.hidden = true; }, isFault ? 9000 : 4000);
}

/** Human-readable lengths and angles. */
export const formatLength = (metres) => {
  const mm = 1000 * metres;
  return mm < 10 ? `${mm.toFixed(1)} mm` : mm < 1000 ? `${mm.toFixed(0)} mm` : `${metres.toFixed(1)} m`;
};
export const formatAngle = (radians, digits = 2) => `${(radians * 180 / Math.PI).toFixed(digits).replace(/^-(0\.0+)$/, '$1')}°`;
