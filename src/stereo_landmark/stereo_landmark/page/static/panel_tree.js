// Part 4: the procedure tree, and whether it works (paper 4d).

import { activeTarget, app, ask, changed } from './app.js';
import { el } from './dom.js';
import { targetTabs } from './panel_targets.js';

const WORDS = { found: 'found', ambiguous: 'ambiguous', missed: 'not found', mistaken: 'mistaken' };
let isChecking = false;

export async function check() {
  const { active } = app.state;
  if (isChecking || !activeTarget().primitives.length) return;
  isChecking = true;
  changed();
  await ask('check', { target: active });
  isChecking = false;
  changed();
}

function trialRow(trial) {
  const what = trial.hidden.length ? `${trial.hidden.join(', ')} hidden` : 'Everything in view';
  return el('li', { className: `trial ${trial.outcome}`, 'data-testid': 'trial', title: trial.detail },
    el('span', { className: 'mark' }), el('span', { className: 'name' }, what), el('b', {}, WORDS[trial.outcome]));
}

export function panelTree() {
  const result = app.state.checks[app.state.active];
  const good = result?.trials.filter((trial) => trial.outcome === 'found').length;
  return [
    el('h2', {}, 'Procedure tree'), targetTabs(),
    el('p', {}, 'The robot looks for the first primitive in the whole image, then for the others in windows around it. When a path fails it takes the next one.'),
    el('button', { className: 'wide primary', 'data-testid': 'check', disabled: isChecking || !activeTarget().primitives.length, onclick: check },
      isChecking ? 'Checking …' : 'Check the tree'),
    result && el('p', { className: `expected ${good === result.trials.length ? 'good' : 'weak'}`, 'data-testid': 'check-result' },
      el('b', {}, `${good} of ${result.trials.length} found`), el('span', {}, 'on the taught images, with parts hidden')),
    result && el('ul', { className: 'trials' }, ...result.trials.map(trialRow)),
  ];
}
