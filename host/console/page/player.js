// Play, pause, scrub and speed, where a log is looked at.

import { clock, element } from "./format.js";

export class Player {
  constructor(connection, orders) {
    this.connection = connection;
    this.orders = orders;
    this.scrubbing = false;
    this.playing = false;
    element("play").addEventListener("click", () => this.send({ do: this.playing ? "pause" : "play" }));
    element("speed").addEventListener("change", ({ target }) => this.send({ do: "speed", factor: Number(target.value) }));
    const scrub = element("scrub");
    scrub.addEventListener("input", () => {
      this.scrubbing = true;
      this.send({ do: "seek", at_s: Number(scrub.value) });
    });
    scrub.addEventListener("change", () => (this.scrubbing = false));
  }

  async send(command) {
    const answer = await this.connection.send(command);
    if (!answer.ok) this.orders.say(answer);
  }

  show(play, may) {
    element("player").hidden = !play;
    if (!play) return;
    this.playing = play.playing;
    const [button, scrub, speed] = [element("play"), element("scrub"), element("speed")];
    button.textContent = play.playing ? "pause" : "play";
    for (const control of [button, scrub, speed]) control.disabled = !may;
    scrub.min = play.begin_s;
    scrub.max = play.end_s;
    if (!this.scrubbing) scrub.value = play.at_s;
    if (document.activeElement !== speed) speed.value = String(play.speed);
    element("played").textContent = `${clock(play.at_s - play.begin_s)} of ${clock(play.end_s - play.begin_s)}${play.cut ? ", cut" : ""}`;
  }
}
