// The page: header, parts, hints, keys.

import { app, ask, changed, connect, onChange, step } from './app.js';
import { byId, el } from './dom.js';
import { listenToKeys, showKeys } from './keys.js';
import { drawEdges, panelProcessing } from './panel_processing.js';
import { panelPoints } from './panel_points.js';
import { panelTargets } from './panel_targets.js';
import { panelTest, save, takeName, test } from './panel_test.js';
import { check, panelTree } from './panel_tree.js';
import { updateStage } from './stage.js';

export const PARTS = {
  processing: { title: 'Image processing', panel: panelProcessing, tip: 'Drag a slider; the edges follow. Double click a slider for its default. Wheel zooms, Alt+drag moves.' },
  targets: { title: 'Targets', panel: panelTargets, tip: 'Drag a region, click shapes to choose them; X goes through shapes upon each other. Del takes out, Alt+↑ ↓ reorders, Esc cancels.' },
  points: { title: 'Corresponding points', panel: panelPoints, tip: 'Click a cross to leave the point out or take it back. Drag in the lower view to turn it.' },
  tree: { title: 'Procedure tree', panel: panelTree, tip: 'Branches are tried from the thickest to the thinnest.' },
  test: { title: 'Test and save', panel: panelTest, tip: 'Green crosses make the pose, amber ones were left out as inconsistent.' },
};

/** How far each part is: hints in it, or done. */
function standing(part) {
  const { targets } = app.state;
  const has = (list) => list.length > 0;
  switch (part) {
    case 'processing': return 'good';
    case 'targets': return targets.every((each) => has(each.primitives)) ? worst(targets.flatMap((each) => each.hints)) : 'open';
    case 'points': return targets.every((each) => each.expected.is_fix) ? 'good' : 'open';
    case 'tree': { const done = Object.values(app.state.checks); return done.length === targets.length ? worst(done.flatMap((each) => each.hints)) : 'open'; }
    default: return app.test ? (app.test.is_fix ? 'good' : 'stop') : 'open';
  }
}

const worst = (hints) => (hints.some((h) => h.weight === 'stop') ? 'stop' : hints.some((h) => h.weight === 'weak') ? 'weak' : 'good');

export function goTo(part) {
  app.part = part;
  app.hover = null;
  byId('cursor').textContent = '';
  if (part === 'processing') drawEdges();
  if (part === 'tree' && !app.state.checks[app.state.active]) check();
  if (part === 'test' && app.testPair === null && app.state.pairs.length > 1) app.testPair = (app.state.pair + 1) % app.state.pairs.length;
  if (part === 'test' && !app.test && app.state.targets.every((each) => each.expected.is_fix)) test();
  changed();
}

function updateHeader() {
  const { state, greeting } = app;
  const place = byId('place');
  if (document.activeElement !== place && place.dataset.isOwn !== 'true') place.value = state.place;
  byId('pair').replaceChildren(...state.pairs.map((label, i) => el('option', { value: i, selected: i === state.pair }, `${i + 1}: ${label}`)));
  byId('take').hidden = !greeting.is_live;
  byId('undo').disabled = !state.can_undo;
  byId('redo').disabled = !state.can_redo;
  byId('save').disabled = app.isSaving;
  byId('save').textContent = app.isSaving ? 'Saving …' : { saved: 'Saved ✓', unsaved: 'Save •', new: 'Save' }[state.keeping];
  byId('save').title = `Save the place (Ctrl+S)${state.keeping === 'unsaved' ? ': there are changes that are not saved' : ''}`;
  byId('parts').replaceChildren(...Object.entries(PARTS).map(([part, { title }], i) => el('button', {
    role: 'tab', className: `part ${standing(part)}${part === app.part ? ' on' : ''}`, 'aria-selected': String(part === app.part),
    'data-testid': `part-${part}`, title: `Key ${i + 1}`, onclick: () => goTo(part),
  }, el('span', { className: 'number' }, String(i + 1)), title, el('span', { className: 'dot' }))));
  byId('tip').textContent = PARTS[app.part].tip;
}

function updateHints() {
  const hints = [...app.state.targets.flatMap((each) => each.hints), ...Object.values(app.state.checks).flatMap((each) => each.hints)];
  const isEmpty = app.state.targets.every((each) => !each.primitives.length);
  const rows = hints.filter(() => !isEmpty).map((hint) => el('div', {
    className: `hint ${hint.weight}`, 'data-testid': 'hint', onclick: () => { app.selected = hint.about.split('/')[0] || null; changed(); },
  }, el('b', {}, app.state.targets.length > 1 ? `${hint.target}: ` : ''), hint.text));
  byId('hints').replaceChildren(...rows);
  byId('hints').hidden = !rows.length;
}

function updatePanel() {
  const panel = byId('panel');
  // A slider or a field that is in use must not be replaced under the hand.
  const used = document.activeElement;
  if (panel.contains(used) && used.matches('input[type=range], input[type=number]') && panel.dataset.part === app.part && used.matches(':active')) return;
  const focused = panel.contains(used) ? used.dataset.testid : null;
  const scroll = panel.scrollTop;
  panel.replaceChildren(...PARTS[app.part].panel().filter(Boolean));
  panel.dataset.part = app.part;
  panel.scrollTop = scroll;
  if (focused) panel.querySelector(`[data-testid="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

onChange(() => {
  if (!app.state) return;
  byId('curtain').hidden = true;
  document.body.classList.toggle('down', !app.isUp);
  updateHeader();
  updatePanel();
  updateHints();
  updateStage();
});

byId('place').addEventListener('change', takeName);
byId('pair').addEventListener('change', async (event) => { await step('take_pair', { pair: Number(event.target.value) }); if (app.part === 'processing') drawEdges(); });
byId('take').addEventListener('click', async () => { await step('take'); if (app.part === 'processing') drawEdges(); });
byId('undo').addEventListener('click', () => back('undo'));
byId('redo').addEventListener('click', () => back('redo'));
byId('save').addEventListener('click', () => save());
byId('help').addEventListener('click', showKeys);
window.addEventListener('beforeunload', (event) => { if (app.state?.keeping === 'unsaved') event.preventDefault(); });

export async function back(which) {
  if (!app.state[`can_${which}`]) return;
  await step(which);
  if (app.part === 'processing') drawEdges();
}

listenToKeys({ goTo, back });
connect(() => { drawEdges(); ask('snapshot'); });
