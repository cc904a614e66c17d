// What the page knows, and how it makes steps.

import { Connection } from './connection.js';
import { toast } from './dom.js';

export const app = {
  greeting: null,
  state: null,
  part: 'processing',
  /** Only on this page: the primitive under the cursor, the result of a test, the step that waits for its answer. */
  hover: null,
  selected: null,
  edges: {},
  test: null,
  testPair: null,
  pending: null,
  isSaving: false,
  isUp: false,
  connection: null,
};

const listeners = [];

/** Call a function after every change. */
export const onChange = (listener) => listeners.push(listener);

/** Show tests what the page shows people. */
export function publish() {
  window.__state = {
    part: app.part, state: app.state, selected: app.selected, checks: app.state?.checks, test: app.test,
    keeping: app.state?.keeping, isUp: app.isUp, edges: Object.fromEntries(
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
    takeState(answer.state);
    return answer;
  } catch (fault) {
    takeState(fault.answer?.state);
    if (!fault.answer?.exists) toast(fault.message, true);
    return { error: fault.message, ...fault.answer };
  }
}

/** Whoever made the step: a test of another choice holds no more. */
function takeState(state) {
  if (!state) return;
  if (state.choice !== app.state?.choice) app.test = null;
  app.state = state;
  changed();
}

/** Make a step of the engineer. */
export function step(what, fields = {}) {
  const asked = ask(what, fields);
  app.pending = asked;
  asked.then(() => { if (app.pending === asked) app.pending = null; });
  return asked;
}

export const activeTarget = () => app.state.targets[app.state.active];
