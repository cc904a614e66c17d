// The WebSocket: requests with numbers, answers with the same ones.

export class Connection {
  /** onChange: called when another page made a step; onUp(isUp): when the server comes or goes. */
  constructor(onChange, onUp) {
    this.onChange = onChange;
    this.onUp = onUp;
    this.waiting = new Map();
    this.count = 0;
    this.open();
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.onopen = () => this.onUp(true);
    this.socket.onmessage = (event) => this.take(JSON.parse(event.data));
    this.socket.onclose = () => {
      for (const { reject } of this.waiting.values()) reject(new Error('the server does not answer; is it still running?'));
      this.waiting.clear();
      this.onUp(false);
      setTimeout(() => this.open(), 1000);
    };
  }

  take(answer) {
    if (answer.changed) { this.onChange(); return; }
    const { resolve, reject } = this.waiting.get(answer.id) ?? {};
    this.waiting.delete(answer.id);
    if (!resolve) return;
    if (answer.error) reject(Object.assign(new Error(answer.error), { answer }));
    else resolve(answer);
  }

  ask(what, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error('no connection to the server'));
    this.count += 1;
    const id = this.count;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.socket.send(JSON.stringify({ id, do: what, ...fields }));
    });
  }
}

/** Runs one piece of work at a time; of those that come meanwhile only the latest is done. */
export class LatestWins {
  constructor(work) {
    this.work = work;
    this.isBusy = false;
    this.next = null;
    this.sent = 0;
    this.skipped = 0;
  }

  async give(value) {
    if (this.isBusy) {
      if (this.next) this.skipped += 1;
      this.next = { value };
      return;
    }
    this.isBusy = true;
    try {
      this.next = { value };
      while (this.next) {
        const now = this.next.value;
        this.next = null;
        this.sent += 1;
        // Each value waits for the answer to the one before: that is the point.
        await this.work(now);
      }
    } finally {
      this.isBusy = false;
    }
  }
}
