// Helpers that create page elements.

export const byId = (id) => document.getElementById(id);

/** Create an element: on… handlers, properties and attributes by name, then children or strings. */
export function el(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name === 'colour') made.style.background = value;
    else if (name in made) made[name] = value;
    else made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

/** Replace the children of an element only if its content differs, so that selections and focus stay. */
export function fill(id, children) {
  const box = byId(id);
  const made = el('div', {}, children);
  if (box.innerHTML !== made.innerHTML) box.replaceChildren(...made.childNodes);
}

let hiding = 0;

export function toast(text, isFault = false) {
  const box = byId('toast');
  box.textContent = text;
  box.className = isFault ? 'bad' : '';
  box.hidden = false;
  clearTimeout(hiding);
  hiding = setTimeout(() => { box.hidden = true; }, isFault ? 7000 : 3000);
}

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
export const yawOf = (q) => Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
export const seconds = (stamp) => stamp.sec + 1e-9 * stamp.nanosec;
export const degrees = (radians) => `${(radians * 180 / Math.PI).toFixed(1)}°`;
export const length = (metres) => (Math.abs(metres) < 0.0995 ? `${(1000 * metres).toFixed(Math.abs(metres) < 0.00095 ? 2 : 1)} mm` : `${metres.toFixed(2)} m`);
