// Part 2: regions, detectors, the choice among what they find, and its order (paper 4b).

import { activeTarget, app, changed, step } from './app.js';
import { COLOURS, KIND_KEYS, KIND_NAMES, byId, el, kindIcon } from './dom.js';

let dragged = null;

export function targetTabs() {
  const tabs = app.state.targets.map((target, i) => el('button', {
    className: `tab${i === app.state.active ? ' on' : ''}`, 'data-testid': `target-${i}`, title: 'Double click for another name',
    onclick: () => { if (i !== app.state.active) { app.selected = null; step('work_on_target', { target: i }); } },
    ondblclick: () => rename(target.name, (name) => step('name_target', { target: i, name })),
  }, target.name, el('span', { className: 'count' }, String(target.primitives.length))));
  return el('div', { className: 'tabs' }, ...tabs,
    el('button', { className: 'tab add', 'data-testid': 'add-target', title: 'Another target (N)', onclick: () => step('add_target') }, '+'),
    el('span', { className: 'grow' }),
    el('button', { className: 'quiet', title: 'Remove this target', 'data-testid': 'remove-target', onclick: () => step('remove_target', { target: app.state.active }) }, 'Remove'));
}

/** Ask for a name in a small window. */
export function rename(old, onName) {
  const dialog = byId('dialog');
  const input = el('input', { value: old, 'data-testid': 'rename' });
  dialog.replaceChildren(el('form', { method: 'dialog', onsubmit: () => { if (input.value !== old) onName(input.value.trim()); } },
    el('h3', {}, 'Name'), input, el('div', { className: 'row' }, el('span', { className: 'grow' }),
      el('button', { type: 'button', onclick: () => dialog.close() }, 'Cancel'), el('button', { className: 'primary' }, 'Rename'))));
  dialog.showModal();
  input.select();
}

function detectors() {
  return el('div', { className: 'detectors' }, ...app.greeting.kinds.map((kind) => {
    const isOn = app.state.kinds.includes(kind);
    const count = app.state.found.filter((each) => each.kind === kind).length;
    return el('button', {
      className: `detector${isOn ? ' on' : ''}`, 'data-testid': `detector-${kind}`, 'aria-pressed': String(isOn), title: `Key ${KIND_KEYS[kind].toUpperCase()}`,
      style: isOn ? { borderColor: COLOURS[kind] } : {}, onclick: () => step('show_kind', { kind, shown: !isOn }),
    }, kindIcon(kind), el('span', {}, KIND_NAMES[kind]), el('b', {}, isOn ? String(count) : '–'));
  }));
}

function row(part, i) {
  const isSelected = part.name === app.selected;
  return el('li', {
    className: `${isSelected ? 'selected' : ''}${part.fault ? ' fault' : ''}`, 'data-testid': `chosen-${i}`, 'data-name': part.name,
    onclick: () => { app.selected = isSelected ? null : part.name; changed(); },
    ondblclick: () => rename(part.name, (to) => step('name_primitive', { name: part.name, to })),
  },
  el('span', { className: 'handle', title: 'Drag to reorder (or Alt+↑ ↓)', 'data-testid': `handle-${i}`, onpointerdown: (event) => startDrag(event, part.name) }, '⠿'),
  el('span', { className: 'number', style: { background: part.fault ? '#ff6b6b' : COLOURS[part.kind] } }, String(i + 1)),
  kindIcon(part.kind), el('span', { className: 'name' }, part.name),
  el('button', { className: 'quiet', title: 'Take it out (Delete)', 'data-testid': `drop-${i}`, onclick: (event) => { event.stopPropagation(); drop(part.name); } }, '✕'));
}

export function drop(name) {
  if (app.selected === name) app.selected = null;
  return step('drop', { name });
}

/** Rows follow the pointer; where it is let go the primitive is looked for from now on. */
function startDrag(event, name) {
  event.preventDefault();
  dragged = { name, list: event.target.closest('ol'), row: event.target.closest('li') };
  dragged.row.classList.add('dragged');
  window.addEventListener('pointermove', onDrag);
  window.addEventListener('pointerup', endDrag, { once: true });
}

function onDrag(event) {
  const others = [...dragged.list.children].filter((each) => each !== dragged.row);
  const next = others.find((each) => { const box = each.getBoundingClientRect(); return event.clientY < box.top + box.height / 2; });
  dragged.list.insertBefore(dragged.row, next ?? null);
}

/** End a drag; without a new order when it is cancelled. */
export function endDrag(event) {
  if (!dragged) return false;
  window.removeEventListener('pointermove', onDrag);
  window.removeEventListener('pointerup', endDrag);
  const { name, list, row: moved } = dragged;
  const place = [...list.children].indexOf(moved);
  const isNew = activeTarget().primitives[place]?.name !== name;
  dragged = null;
  if (event && isNew) step('move', { name, place });
  else changed();
  return true;
}

export function panelTargets() {
  const target = activeTarget();
  return [
    el('h2', {}, 'Targets'), targetTabs(),
    el('ol', { className: 'steps' },
      el('li', { className: target.region ? 'done' : 'next' }, 'Drag a rectangle around an object.',
        target.region && el('button', { className: 'quiet', 'data-testid': 'whole-image', onclick: () => step('draw_region', { region: null }) }, 'Whole image')),
      el('li', { className: app.state.kinds.length ? 'done' : 'next' }, 'Run the detectors for its shapes.')),
    detectors(),
    el('ol', { className: 'steps', start: 3 },
      el('li', { className: target.primitives.length ? 'done' : 'next' }, 'Click on the shapes that make it up.'),
      el('li', {}, 'Order them: what is surest to be seen and rarest first.')),
    target.primitives.length ? el('ol', { className: 'chosen', 'data-testid': 'chosen' }, ...target.primitives.map(row))
      : el('p', { className: 'empty' }, app.state.found.length ? 'Nothing chosen yet.' : 'The detectors find nothing in this region. Try a larger one, more detectors, or a lower threshold in part 1.'),
  ];
}
