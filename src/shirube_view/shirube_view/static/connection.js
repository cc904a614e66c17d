// WebSocket of the page: opens again when it closes; pictures arrive as bytes, everything else as JSON.

export class Connection {
  /** handlers: onMessage(object), onPicture(index, blob), onConnection(isOpen). */
  constructor(handlers) {
    this.handlers = handlers;
    this.open();
  }

  open() {
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => this.handlers.onConnection(true);
    this.socket.onmessage = ({ data }) => {
      if (typeof data === 'string') this.handlers.onMessage(JSON.parse(data));
      else this.handlers.onPicture(new Uint8Array(data, 0, 1)[0], new Blob([new Uint8Array(data, 1)], { type: 'image/jpeg' }));
    };
    this.socket.onclose = () => {
      this.handlers.onConnection(false);
      setTimeout(() => this.open(), 1000);
    };
  }

  send(what, fields = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ do: what, ...fields }));
    return true;
  }
}
