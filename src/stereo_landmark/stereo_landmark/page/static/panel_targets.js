// Step 2: regions, detectors, selection of primitives and their order (paper 4b).

import { activeTarget, app, changed, edit } from './app.js';
import { COLOURS, KIND_KEYS, KIND_NAMES, byId, el, kindIcon } from './dom.js';
import { stage } from './stage.js';

const RECALL_TESTS_MIN = 3;

let dragged = null;

export function targetTabs() {
  const tabs = app.state.targets.map((target, i) => el('button', {
    className: `tab${i === app.state.active ? ' on' : ''}`, 'data-testid': `target-${i}`, title: i === app.state.active ? 'Click again to rename' : '', 'aria-pressed': String(i === app.state.active),
    onclick: () => {
      if (i === app.state.active) { rename(target.name, (name) => edit('rename_target', { target: i, name })); return; }
      app.selected = null;
      edit('activate_target', { target: i });
    },
  }, target.name, el('span', { className: 'count' }, String(target.primitives.length))));
  return el('div', { className: 'tabs' }, ...tabs,
    el('button', { className: 'tab add', 'data-testid': 'add-target', title: 'Add a target (N)', 'aria-label': 'Add a target', onclick: () => edit('add_target') }, '+'),
    el('span', { className: 'grow' }),
    el('button', { className: 'quiet', title: 'Remove this target', 'data-testid': 'remove-target', onclick: () => edit('remove_target', { target: app.state.active }) }, 'Remove'));
}

/** Ask for a name in a dialog. */
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
  return el('div', { className: 'detectors' }, ...app.configuration.kinds.map((kind) => {
    const isOn = app.state.kinds.includes(kind);
    const count = app.state.found.filter((each) => each.kind === kind).length;
    return el('button', {
      className: `detector${isOn ? ' on' : ''}`, 'data-testid': `detector-${kind}`, 'aria-pressed': String(isOn), title: `Key ${KIND_KEYS[kind].toUpperCase()}`,
      style: isOn ? { borderColor: COLOURS[kind] } : {}, onclick: () => edit('show_kind', { kind, shown: !isOn }),
    }, kindIcon(kind), el('span', {}, KIND_NAMES[kind]), el('b', {}, isOn ? String(count) : '–'));
  }));
}

/** Where the shapes of the region can be used, which cannot and why; also by keyboard and by screen reader. */
function shapeList() {
  const { found } = app.state;
  const refused = found.filter((each) => each.fault);
  if (!found.length) return null;
  return el('details', { className: 'shapes', open: app['open-shapes'] ?? false, ontoggle: (event) => { if (event.target.open !== (app['open-shapes'] ?? false)) { app['open-shapes'] = event.target.open; changed(); } } },
    el('summary', { 'data-testid': 'shape-counts' }, el('span', {}, `${found.length - refused.length} shapes can be used, ${refused.length ? `${refused.length} cannot (dotted)` : 'all of them'}`)),
    app['open-shapes'] && el('ul', {}, ...[...found.filter((each) => !each.fault), ...refused].map(shapeRow)));
}

function shapeRow(found) {
  const key = stage.keyOf(found);
  const size = found.fault || `${found.depth.toFixed(1)} m away${found.chosen ? `, selected as ${found.chosen}` : ''}`;
  return el('li', {}, el('button', {
    className: `shape${found.fault ? ' refused' : ''}`, 'data-hover': key, 'data-testid': `shape-${key}`, 'aria-pressed': String(Boolean(found.chosen)), 'aria-disabled': String(Boolean(found.fault)),
    onmouseenter: () => stage.hover(key), onmouseleave: () => stage.hover(null), onfocus: () => stage.hover(key), onblur: () => stage.hover(null), onclick: () => stage.choose(found),
  }, kindIcon(found.kind), el('span', { className: 'name' }, `${KIND_NAMES[found.kind]} ${found.number + 1}`), el('small', {}, size)));
}

/** Share of the tested images with a position in which a shape of the active target was found. */
function recall(name) {
  const tests = Object.values(app.state.tests).filter((test) => test.is_fix);
  if (tests.length < RECALL_TESTS_MIN) return null;
  return tests.filter((test) => test.found[activeTarget().name]?.includes(name)).length / tests.length;
}

function removeRefused() {
  const count = app.state.targets.flatMap((target) => target.primitives).filter((each) => each.fault).length;
  return count > 0 && el('div', { className: 'refused-note', role: 'status' },
    el('span', {}, `${count} selected ${count === 1 ? 'shape' : 'shapes'} cannot be used. The place is taught without ${count === 1 ? 'it' : 'them'}.`),
    el('button', { className: 'wide', 'data-testid': 'remove-refused', onclick: () => { app.selected = null; edit('remove_refused'); } }, 'Remove all that cannot be used'));
}

function row(primitive, i) {
  const share = recall(primitive.name);
  const isSelected = primitive.name === app.selected;
  return el('li', {
    className: `${isSelected ? 'selected' : ''}${primitive.fault ? ' fault' : ''}`, title: primitive.fault, 'data-testid': `chosen-${i}`, 'data-name': primitive.name,
    onclick: () => { app.selected = isSelected ? null : primitive.name; changed(); },
  },
  el('span', { className: 'handle', title: 'Drag to reorder (or Alt+↑ ↓)', 'data-testid': `handle-${i}`, onpointerdown: (event) => startDrag(event, primitive.name) }, '⠿'),
  el('span', { className: 'number', style: { background: primitive.fault ? '#ff6b6b' : COLOURS[primitive.kind] } }, String(i + 1)),
  kindIcon(primitive.kind), el('span', { className: 'name', title: isSelected ? 'Click again to rename' : '', onclick: (event) => { if (isSelected) { event.stopPropagation(); rename(primitive.name, (to) => edit('rename_primitive', { name: primitive.name, to })); } } },
    primitive.name, primitive.fault && el('small', {}, primitive.fault)),
  share !== null && el('span', { className: `recall${share < 0.7 ? ' low' : ''}`, title: `found in ${Math.round(100 * share)} % of the tested images` }, `${Math.round(100 * share)} %`),
  el('button', { className: 'quiet', title: 'Remove (Delete)', 'aria-label': `Remove ${primitive.name}`, 'data-testid': `drop-${i}`, onclick: (event) => { event.stopPropagation(); drop(primitive.name); } }, '✕'));
}

export function drop(name) {
  if (app.selected === name) app.selected = null;
  return edit('drop', { name });
}

/** Rows follow the pointer; the drop position is the new place in the order. */
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

/** End a drag; a cancelled drag keeps the order. */
export function endDrag(event) {
  if (!dragged) return false;
  window.removeEventListener('pointermove', onDrag);
  window.removeEventListener('pointerup', endDrag);
  const { name, list, row: moved } = dragged;
  const place = [...list.children].indexOf(moved);
  const isNew = activeTarget().primitives[place]?.name !== name;
  dragged = null;
  if (event && isNew) edit('move', { name, place });
  else changed();
  return true;
}

export function panelTargets() {
  const target = activeTarget();
  return [
    el('h2', {}, 'Targets'), targetTabs(),
    el('ol', { className: 'steps' },
      el('li', { className: target.region ? 'done' : 'next' }, 'Drag a rectangle around an object.',
        target.region && el('button', { className: 'quiet', 'data-testid': 'whole-image', onclick: () => edit('set_region', { region: null }) }, 'Whole image')),
      el('li', { className: app.state.kinds.length ? 'done' : 'next' }, 'Run the detectors for its shapes.')),
    detectors(), shapeList(),
    el('ol', { className: 'steps', start: 3 },
      el('li', { className: target.primitives.length ? 'done' : 'next' }, 'Click on its shapes. Dotted ones cannot be used; the reason is shown when you point at them.'),
      el('li', {}, 'Order them: the most reliable and rarest first.')),
    removeRefused(),
    target.primitives.length ? el('ol', { className: 'chosen', 'data-testid': 'chosen' }, ...target.primitives.map(row))
      : el('p', { className: 'empty' }, app.state.found.length ? 'Nothing selected yet.' : 'The detectors find nothing in this region. Try a larger one, more detectors, or a lower threshold in step 1.'),
  ];
}
