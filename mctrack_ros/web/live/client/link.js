// The web socket to the server: opened again when it is lost, what comes handed on.
import { IMAGE, headOf } from 'mctrack-live/world.js';

const TAKEN = 'a';
const PAUSE_MS = 1000;

export class Link {
  // heard: told(message), frame(head, buffer), image(head, buffer), open(), lost()
  constructor(path, heard) {
    Object.assign(this, { path, heard, socket: null, closed: false });
    this.open();
  }

  open() {
    if (this.closed) return;
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}${this.path}`);
    this.socket = socket;
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.heard.open();
    socket.onmessage = ({ data }) => this.take(socket, data);
    socket.onclose = () => {
      this.heard.lost();
      setTimeout(() => this.open(), PAUSE_MS);
    };
  }

  async take(socket, data) {
    if (typeof data === 'string') {
      this.heard.told(JSON.parse(data));
      return;
    }
    const head = headOf(data);
    try {
      if (head.kind === IMAGE) await this.heard.image(head, data);
      else this.heard.frame(head, data);
    } finally {
      if (socket.readyState === WebSocket.OPEN) socket.send(TAKEN);
    }
  }

  ask(request) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  close() {
    this.closed = true;
    this.socket.close();
  }
}
