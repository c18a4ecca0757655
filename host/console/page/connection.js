// The WebSocket to the server: it is opened again when it breaks, and every command gets its answer or an error.

const RETRY_MS = 1000;
const ANSWER_MS = 5000;

export class Connection {
  /** @param {(message: object) => void} onMessage  @param {(open: boolean) => void} onChange */
  constructor(onMessage, onChange) {
    this.onMessage = onMessage;
    this.onChange = onChange;
    this.waiting = new Map();
    this.nextId = 1;
    /** Whether the server takes commands from this page. */
    this.may = false;
    this.token = new URLSearchParams(location.hash.slice(1)).get("token");
    this.open();
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`, "flotilla.console.v1");
    this.socket.onopen = async () => {
      if (this.token) {
        const { ok } = await this.send({ do: "hello", token: this.token });
        this.may = ok;
      }
      this.onChange(true);
    };
    this.socket.onmessage = ({ data }) => this.take(JSON.parse(data));
    this.socket.onclose = () => {
      this.may = false;
      for (const settle of this.waiting.values()) settle({ ok: false, text: "the connection broke before the answer came" });
      this.waiting.clear();
      this.onChange(false);
      setTimeout(() => this.open(), RETRY_MS);
    };
  }

  take(message) {
    if (message.kind !== "answer") {
      this.onMessage(message);
      return;
    }
    this.waiting.get(message.id)?.(message);
    this.waiting.delete(message.id);
  }

  /** Sends a command. The promise is never rejected: without an answer it ends with `ok: false` and why. */
  send(command) {
    if (!this.isOpen) return Promise.resolve({ ok: false, text: "not connected: the command was not sent" });
    const id = this.nextId;
    this.nextId = (this.nextId + 1) % 2 ** 32;
    return new Promise((resolve) => {
      const timer = setTimeout(() => {
        this.waiting.delete(id);
        resolve({ ok: false, text: `no answer for ${ANSWER_MS / 1000} s` });
      }, ANSWER_MS);
      this.waiting.set(id, (answer) => {
        clearTimeout(timer);
        resolve(answer);
      });
      this.socket.send(JSON.stringify({ id, ...command }));
    });
  }
}
