// Emergency stop, hold, resume, release, end: buttons and keys. The space bar stops the fleet wherever the focus is.

import { element } from "./format.js";

export class Orders {
  constructor(connection) {
    this.connection = connection;
    this.buttons = Object.fromEntries(["stop", "hold", "resume", "release", "end"].map((name) => [name, element(name)]));
    for (const [name, button] of Object.entries(this.buttons)) {
      button.addEventListener("click", () => this.order(name));
    }
    // In the capturing phase, before a button in focus takes the key for a click.
    window.addEventListener("keydown", (event) => this.key(event), true);
    window.addEventListener("keyup", (event) => event.code === "Space" && event.preventDefault(), true);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.code === "Space") {
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) this.order("stop");
    } else if (event.code === "KeyH" && !event.repeat) {
      this.order("hold");
    } else if (event.code === "KeyR" && !event.repeat) {
      this.order("resume");
    }
  }

  async order(name, more = {}) {
    if (!this.connection.may) {
      this.say({ ok: false, text: this.connection.isOpen ? `${name}: this page only looks (no token in its address)` : `${name}: not connected, not sent` });
      return;
    }
    if (name === "end" && !window.confirm("End the run?")) return;
    this.say({ ok: true, text: `${name}…` });
    this.say(await this.connection.send({ do: name, ...more }));
  }

  say({ ok, text }) {
    const answer = element("answer");
    answer.textContent = text;
    answer.className = ok ? "" : "bad";
  }

  /** What can be pressed now. */
  show(snapshot, can) {
    const may = this.connection.may && can.order && snapshot.ended === null;
    const { stop, hold, resume, release, end } = this.buttons;
    element("orders").hidden = !can.order;
    stop.disabled = !may;
    hold.disabled = !may || snapshot.order !== null;
    resume.disabled = !may || snapshot.order !== "hold";
    release.disabled = !may || snapshot.order === null;
    end.disabled = !may;
  }
}
