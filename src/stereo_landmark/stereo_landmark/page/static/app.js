// What the page knows, and how it makes steps.

import { Connection } from './connection.js';
import { toast } from './dom.js';

export const app = {
  greeting: null,
  state: null,
  part: 'processing',
  /** Only on this page: the primitive under the cursor, results of checks and tests, whether all is saved. */
  hover: null,
  selected: null,
  edges: {},
  checks: {},
  test: null,
  testPair: null,
  isSaved: true,
  isUp: false,
  connection: null,
};

const listeners = [];

/** Call a function after every change. */
export const onChange = (listener) => listeners.push(listener);

/** Show tests what the page shows people. */
export function publish() {
  window.__state = {
    part: app.part, state: app.state, selected: app.selected, checks: app.checks, test: app.test,
    isSaved: app.isSaved, isUp: app.isUp, edges: Object.fromEntries(
      Object.entries(app.edges).map(([side, edges]) => [side, edges.count])),
  };
}

/** Tell everybody that something changed. */
export function changed() {
  publish();
  listeners.forEach((listener) => listener());
}

export function connect(onFirst) {
  app.connection = new Connection(() => ask('snapshot'), async (isUp) => {
    app.isUp = isUp;
    if (isUp) {
      const isFirst = !app.greeting;
      await ask('hello');
      if (isFirst && app.state) onFirst();
    } else if (app.greeting) toast('The server does not answer. Is it still running?', true);
    changed();
  });
}

/** Ask for something; faults become a line on the page. */
export async function ask(what, fields = {}) {
  try {
    const answer = await app.connection.ask(what, fields);
    if (answer.greeting) app.greeting = answer.greeting;
    if (answer.state) app.state = answer.state;
    if (answer.state) changed();
    return answer;
  } catch (fault) {
    if (!fault.answer?.exists) toast(fault.message, true);
    return { error: fault.message, ...fault.answer };
  }
}

/** Make a step of the engineer: what was checked and tested before holds no more. */
export async function step(what, fields = {}) {
  const answer = await ask(what, fields);
  if (!answer.error) {
    app.isSaved = false;
    app.checks = {};
    app.test = null;
    changed();
  }
  return answer;
}

export const activeTarget = () => app.state.targets[app.state.active];
