// WebSocket connection: requests and responses with matching IDs.

export class Connection {
  /** onChange: called when another page made an edit; onConnection(isConnected): when the connection opens or closes. */
  constructor(onChange, onConnection) {
    this.onChange = onChange;
    this.onConnection = onConnection;
    this.waiting = new Map();
    this.count = 0;
    this.open();
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.onopen = () => this.onConnection(true);
    this.socket.onmessage = (event) => this.receive(JSON.parse(event.data));
    this.socket.onclose = () => {
      for (const { reject } of this.waiting.values()) reject(new Error('the server does not answer; is it still running?'));
      this.waiting.clear();
      this.onConnection(false);
      setTimeout(() => this.open(), 1000);
    };
  }

  receive(answer) {
    if (answer.changed) { this.onChange(); return; }
    const { resolve, reject } = this.waiting.get(answer.id) ?? {};
    this.waiting.delete(answer.id);
    if (!resolve) return;
    if (answer.error) reject(Object.assign(new Error(answer.error), { answer }));
    else resolve(answer);
  }

  request(what, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error('no connection to the server'));
    this.count += 1;
    const id = this.count;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.socket.send(JSON.stringify({ id, do: what, ...fields }));
    });
  }
}

/** Processes one value at a time; of the values queued meanwhile only the latest is processed. */
export class LatestValueQueue {
  constructor(work) {
    this.work = work;
    this.isBusy = false;
    this.next = null;
    this.sent = 0;
    this.skipped = 0;
  }

  async push(value) {
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
        // Sequential on purpose: each value waits for the previous response.
        await this.work(now);
      }
    } finally {
      this.isBusy = false;
    }
  }
}
