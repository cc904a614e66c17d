// The page: header, steps, hints, keys.

import { app, request, changed, connect, onChange, edit } from './app.js';
import { byId, el } from './dom.js';
import { listenToKeys, showKeys } from './keys.js';
import { drawEdges, panelProcessing } from './panel_processing.js';
import { panelPoints } from './panel_points.js';
import { panelTargets } from './panel_targets.js';
import { panelTest, save, submitName, test } from './panel_test.js';
import { testedArea } from './plan_view.js';
import { check, panelTree } from './panel_tree.js';
import { stage, updateStage } from './stage.js';

export const STEPS = {
  processing: { title: 'Image processing', panel: panelProcessing, tip: 'Drag a slider to update the edges. Double click a slider for its default. The wheel or two fingers zoom; Alt+drag or two fingers move the picture.' },
  targets: { title: 'Targets', panel: panelTargets, tip: 'Drag a region, click shapes to select them. Dotted shapes cannot be used. X: next of several overlapping ones. Esc cancels.' },
  points: { title: 'Corresponding points', panel: panelPoints, tip: 'Click a cross to exclude or include the point. Drag in the lower view to rotate it.' },
  tree: { title: 'Procedure tree', panel: panelTree, tip: 'The paths are tried from the first to the last.' },
  test: { title: 'Test and save', panel: panelTest, tip: 'Green crosses were used for the position; amber ones did not fit and were left out.' },
};

/** Status of each step for its dot. */
function stepStatus(step) {
  const { targets } = app.state;
  const has = (list) => list.length > 0;
  switch (step) {
    case 'processing': return 'good';
    case 'targets': return targets.every((each) => has(each.primitives)) ? worst(targets.flatMap((each) => each.hints)) : 'open';
    case 'points': return targets.every((each) => each.expected.is_fix) ? 'good' : 'open';
    case 'tree': { const done = Object.values(app.state.checks); return done.length === targets.length ? worst(done.flatMap((each) => each.hints)) : 'open'; }
    default: { const { tests, missing } = testedArea(); return !tests.length ? 'open' : !missing ? 'good' : missing < tests.length ? 'weak' : 'stop'; }
  }
}

const worst = (hints) => (hints.some((h) => h.severity === 'stop') ? 'stop' : hints.some((h) => h.severity === 'weak') ? 'weak' : 'good');

export function goTo(step) {
  app.step = step;
  app.hover = null;
  byId('reason').textContent = '';
  document.querySelector('main').scrollTop = 0;
  byId('cursor').textContent = '';
  if (step === 'processing') drawEdges();
  if (step === 'tree' && !app.state.checks[app.state.active]) check();
  if (step === 'test' && app.testPair === null && app.state.pairs.length > 1) app.testPair = (app.state.pair + 1) % app.state.pairs.length;
  if (step === 'test' && !app.test && app.state.targets.every((each) => each.expected.is_fix)) test();
  changed();
}

function updateHeader() {
  const { state, configuration } = app;
  const place = byId('place');
  if (document.activeElement !== place && place.dataset.isOwn !== 'true') place.value = state.place;
  byId('pair').replaceChildren(...state.pairs.map((label, i) => el('option', { value: i, selected: i === state.pair }, `${i + 1}: ${label}`)));
  byId('take').hidden = !configuration.is_live;
  byId('undo').disabled = !state.can_undo;
  byId('redo').disabled = !state.can_redo;
  byId('save').disabled = app.isSaving;
  byId('save').textContent = app.isSaving ? 'Saving …' : { saved: 'Saved ✓', unsaved: 'Save •', new: 'Save' }[state.save_status];
  byId('save').title = `Save the place (Ctrl+S)${state.save_status === 'unsaved' ? ': unsaved changes' : ''}`;
  byId('steps').replaceChildren(...Object.entries(STEPS).map(([step, { title }], i) => el('button', {
    role: 'tab', className: `step ${stepStatus(step)}${step === app.step ? ' on' : ''}`, 'aria-selected': String(step === app.step),
    'data-testid': `step-${step}`, title: `Key ${i + 1}`, 'aria-label': `Step ${i + 1}: ${title}`, onclick: () => goTo(step),
  }, el('span', { className: 'number' }, String(i + 1)), el('span', { className: 'title' }, title), el('span', { className: 'dot' }))));
  byId('tip').textContent = STEPS[app.step].tip;
  byId('next-shape').hidden = app.step !== 'targets';
}

function updateHints() {
  const hints = [...app.state.targets.flatMap((each) => each.hints), ...Object.values(app.state.checks).flatMap((each) => each.hints)];
  const isEmpty = app.state.targets.every((each) => !each.primitives.length);
  const rows = hints.filter(() => !isEmpty).map((hint) => el('button', {
    className: `hint ${hint.severity}`, 'data-testid': 'hint', onclick: () => { app.selected = hint.about.split('/')[0] || null; changed(); },
  }, el('b', {}, app.state.targets.length > 1 ? `${hint.target}: ` : ''), hint.text));
  byId('hints').replaceChildren(...rows);
  byId('hints').hidden = !rows.length;
}

function updatePanel() {
  const panel = byId('panel');
  // A slider or input in use must not be replaced.
  const used = document.activeElement;
  if (panel.contains(used) && used.matches('input[type=range], input[type=number]') && panel.dataset.step === app.step && used.matches(':active')) return;
  const focused = panel.contains(used) ? used.dataset.testid : null;
  const scroll = panel.scrollTop;
  panel.replaceChildren(...STEPS[app.step].panel().filter(Boolean));
  panel.dataset.step = app.step;
  panel.scrollTop = scroll;
  if (focused) panel.querySelector(`[data-testid="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}

onChange(() => {
  if (!app.state) return;
  byId('loading').hidden = true;
  document.body.classList.toggle('down', !app.isConnected);
  updateHeader();
  updatePanel();
  updateHints();
  updateStage();
});

byId('place').addEventListener('change', submitName);
byId('pair').addEventListener('change', async (event) => { await edit('select_pair', { pair: Number(event.target.value) }); if (app.step === 'processing') drawEdges(); });
byId('take').addEventListener('click', async () => { await edit('take'); if (app.step === 'processing') drawEdges(); });
byId('undo').addEventListener('click', () => applyHistory('undo'));
byId('redo').addEventListener('click', () => applyHistory('redo'));
byId('save').addEventListener('click', () => save());
byId('help').addEventListener('click', showKeys);
byId('zoom-in').addEventListener('click', () => stage.zoom(1.4));
byId('zoom-out').addEventListener('click', () => stage.zoom(1 / 1.4));
byId('zoom-fit').addEventListener('click', () => stage.fit());
byId('next-shape').addEventListener('click', () => stage.nextShape());
window.addEventListener('beforeunload', (event) => { if (app.state?.save_status === 'unsaved') event.preventDefault(); });

export async function applyHistory(which) {
  if (!app.state[`can_${which}`]) return;
  await edit(which);
  if (app.step === 'processing') drawEdges();
}

listenToKeys({ goTo, applyHistory });
connect(() => { drawEdges(); request('snapshot'); });
