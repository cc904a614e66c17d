// State of the page, and requests to the server.

import { Connection } from './connection.js';
import { toast } from './dom.js';

export const app = {
  configuration: null,
  state: null,
  step: 'processing',
  /** Local to this page: hovered primitive, test result, pending edit. */
  hover: null,
  selected: null,
  edges: {},
  test: null,
  testPair: null,
  /** Roll and pitch of test images that were set by hand, by pair [rad]. */
  tilts: {},
  /** Number of tested images while all are tested, else null. */
  testing: null,
  pending: null,
  isSaving: false,
  isConnected: false,
  connection: null,
};

const listeners = [];

/** Register a listener for changes. */
export const onChange = (listener) => listeners.push(listener);

/** Expose the state to browser tests. */
export function publish() {
  window.__state = {
    step: app.step, state: app.state, selected: app.selected, checks: app.state?.checks, test: app.test, testing: app.testing,
    save_status: app.state?.save_status, isConnected: app.isConnected, edges: Object.fromEntries(
      Object.entries(app.edges).map(([side, edges]) => [side, edges.count])),
  };
}

/** Notify all listeners of a change. */
export function changed() {
  publish();
  listeners.forEach((listener) => listener());
}

export function connect(onFirst) {
  app.connection = new Connection(() => request('snapshot'), async (isConnected) => {
    app.isConnected = isConnected;
    if (isConnected) {
      const isFirst = !app.configuration;
      await request('hello');
      if (isFirst && app.state) onFirst();
    } else if (app.configuration) toast('The server does not answer. Is it still running?', true);
    changed();
  });
}

/** Send a request; errors are shown as a message. */
export async function request(what, fields = {}) {
  try {
    const answer = await app.connection.request(what, fields);
    if (answer.configuration) app.configuration = answer.configuration;
    applyState(answer.state);
    return answer;
  } catch (fault) {
    applyState(fault.answer?.state);
    if (!fault.answer?.exists) toast(fault.message, true);
    return { error: fault.message, ...fault.answer };
  }
}

/** Apply a new state; a test result of another selection becomes invalid. */
function applyState(state) {
  if (!state) return;
  if (state.selection !== app.state?.selection) app.test = null;
  app.state = state;
  changed();
}

/** Send an edit. */
export function edit(what, fields = {}) {
  const asked = request(what, fields);
  app.pending = asked;
  asked.then(() => { if (app.pending === asked) app.pending = null; });
  return asked;
}

export const activeTarget = () => app.state.targets[app.state.active];
