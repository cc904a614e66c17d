// Step 4: the procedure tree and its test (paper 4d).

import { activeTarget, app, request, changed } from './app.js';
import { el } from './dom.js';
import { targetTabs } from './panel_targets.js';

const OUTCOME_LABELS = { found: 'found', ambiguous: 'could be confused', not_found: 'not found', wrong_pose: 'wrong position' };
let isChecking = false;

export async function check() {
  const { active } = app.state;
  if (isChecking || !activeTarget().primitives.length) return;
  isChecking = true;
  changed();
  await request('check', { target: active });
  isChecking = false;
  changed();
}

function trialRow(trial) {
  const what = trial.hidden.length ? `${trial.hidden.join(', ')} hidden` : 'Everything in view';
  return el('li', { className: `trial ${trial.outcome}`, 'data-testid': 'trial', title: trial.detail },
    el('span', { className: 'mark' }), el('span', { className: 'name' }, what), el('b', {}, OUTCOME_LABELS[trial.outcome]));
}

export function panelTree() {
  const result = app.state.checks[app.state.active];
  const good = result?.trials.filter((trial) => trial.outcome === 'found').length;
  return [
    el('h2', {}, 'Procedure tree'), targetTabs(),
    el('p', {}, 'The robot searches the first shape in the whole image, then the others near where they should be. If a path fails, it tries the next one.'),
    el('button', { className: 'wide primary', 'data-testid': 'check', disabled: isChecking || !activeTarget().primitives.length, onclick: check },
      isChecking ? 'Checking …' : 'Check the tree'),
    result && el('p', { className: `expected ${good === result.trials.length ? 'good' : 'weak'}`, 'data-testid': 'check-result' },
      el('b', {}, `${good} of ${result.trials.length} found`), el('span', {}, 'on the taught images, with shapes hidden')),
    result && el('ul', { className: 'trials' }, ...result.trials.map(trialRow)),
  ];
}
