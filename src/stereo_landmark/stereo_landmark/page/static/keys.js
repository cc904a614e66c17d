// The keyboard.

import { activeTarget, app, changed, edit } from './app.js';
import { KIND_KEYS, byId, el } from './dom.js';
import { drop, endDrag } from './panel_targets.js';
import { markName, save, test } from './panel_test.js';
import { check } from './panel_tree.js';
import { stage } from './stage.js';

const STEPS = ['processing', 'targets', 'points', 'tree', 'test'];

const HELP = [
  ['1 … 5', 'Go to a step'], ['Ctrl+Z', 'Undo'], ['Ctrl+Shift+Z, Ctrl+Y', 'Redo'], ['Esc', 'Cancel in this order: input, drag, selection, zoom, region'],
  ['E  Q  L  C', 'Detectors: ellipses, quadrilaterals, parallel lines, corners'], ['X', 'Next of several overlapping shapes'], ['↑  ↓', 'Select a chosen shape'], ['Alt+↑  Alt+↓', 'Move it up, down in the order'],
  ['Delete', 'Remove the selected shape, or the last one'], ['N', 'Add a target'], ['K', 'Check the procedure tree'], ['T', 'Test on another image'],
  ['Ctrl+S', 'Save'], ['+  −  0', 'Zoom in, out, fit'], ['?', 'These keys'],
];

export function showKeys() {
  const dialog = byId('dialog');
  dialog.replaceChildren(el('form', { method: 'dialog', className: 'keys' }, el('h3', {}, 'Keys'),
    el('dl', {}, ...HELP.flatMap(([keys, what]) => [el('dt', {}, keys), el('dd', {}, what)])), el('button', { className: 'primary' }, 'Close')));
  dialog.showModal();
}

function select(by) {
  const names = activeTarget().primitives.map((primitive) => primitive.name);
  if (!names.length) return;
  const now = names.indexOf(app.selected);
  app.selected = names[Math.min(names.length - 1, Math.max(0, now < 0 ? 0 : now + by))];
  changed();
}

function moveSelected(by) {
  const place = activeTarget().primitives.findIndex((primitive) => primitive.name === app.selected) + by;
  if (place - by >= 0 && place >= 0 && place < activeTarget().primitives.length) edit('move', { name: app.selected, place });
}

function dropSelected() {
  const name = app.selected ?? activeTarget().primitives.at(-1)?.name;
  if (name) drop(name);
}

/** Cancel one thing at a time: drag, selection, zoom, region. */
function cancelInnermost() {
  if (stage.cancelDrag() || endDrag(null)) return;
  if (app.selected || app.hover) { app.selected = null; app.hover = null; changed(); return; }
  if (stage.fit()) return;
  if (app.step === 'targets' && activeTarget().region) edit('set_region', { region: null });
}

/** Restore the value of an input. */
function cancelInput(field) {
  if (field.matches('input')) field.value = field.id === 'place' ? app.state.place : fieldBefore;
  if (field.id === 'place') markName(false);
  field.blur();
}

let fieldBefore = '';

export function listenToKeys({ goTo, applyHistory }) {
  window.addEventListener('focusin', (event) => { fieldBefore = event.target.value; });
  window.addEventListener('keydown', (event) => {
    if (!app.state || byId('dialog').open) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const isControl = event.ctrlKey || event.metaKey;
    if (isControl && key === 's') return act(event, () => save());
    if (event.target.matches('input:not([type=range]):not([type=checkbox]), select')) {
      if (key === 'Escape') cancelInput(event.target);
      return undefined;
    }
    if (isControl && key === 'z') return act(event, () => applyHistory(event.shiftKey ? 'redo' : 'undo'));
    if (isControl && key === 'y') return act(event, () => applyHistory('redo'));
    if (isControl) return undefined;
    if (key === 'Escape') return act(event, cancelInnermost);
    if (event.target.matches('input[type=range]') && key.startsWith('Arrow')) return undefined;
    const kind = Object.keys(KIND_KEYS).find((each) => KIND_KEYS[each] === key);
    if (kind && app.step === 'targets') return act(event, () => edit('show_kind', { kind, shown: !app.state.kinds.includes(kind) }));
    if (STEPS[Number(key) - 1]) return act(event, () => goTo(STEPS[Number(key) - 1]));
    const up = key === 'ArrowUp' ? -1 : key === 'ArrowDown' ? 1 : 0;
    if (up) return act(event, () => (event.altKey ? moveSelected(up) : select(up)));
    const others = {
      Delete: dropSelected, Backspace: dropSelected, n: () => edit('add_target'), k: () => { goTo('tree'); check(); }, t: () => { goTo('test'); test(); },
      x: () => stage.nextShape(), '+': () => stage.zoom(1.4), '=': () => stage.zoom(1.4), '-': () => stage.zoom(1 / 1.4), 0: () => stage.fit(), '?': showKeys,
    };
    return others[key] && act(event, others[key]);
  });
}

function act(event, what) {
  event.preventDefault();
  what();
}
