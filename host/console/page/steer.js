// Targets from the map and the keys: station by click, velocity and heading by drag, waypoints, arrow keys.
//
// A velocity lives only while it is held: it is sent every 100 ms while the pointer or the key is down, and `let-go` when it is
// released, the window loses the focus or the page is hidden. The server holds the fleet when neither comes.

import { FULL_SPEED_PX, isInside } from "./boats.js";
import { element } from "./format.js";

const REFRESH_MS = 100;
const HELP = {
  look: "Drag to move the map, wheel or two fingers to zoom. Arrow keys swim while they are held.",
  station: "Press where the structure is to go and to stay.",
  velocity: "Press and drag: the structure swims that way while the pointer is held, and holds when it is let go.",
  heading: "Drag from the structure to where its front is to point.",
  waypoints: "Press the places one after the other, then swim them. Red comes too near to the water's edge.",
};
const ARROWS = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };

export class Steer {
  constructor(connection, orders, camera, state, onChange) {
    Object.assign(this, { connection, orders, camera, state, onChange });
    this.tool = "look";
    this.keys = new Set();
    this.waypoints = [];
    /** Where the pointer is while it drags, pixels. */
    this.drag = null;
    this.timer = null;
    this.can = false;
    for (const button of document.querySelectorAll("[data-tool]")) {
      button.addEventListener("click", () => this.choose(button.dataset.tool));
    }
    const { canvas } = camera;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(end, (event) => this.up(event));
    }
    window.addEventListener("keydown", (event) => this.key(event, true));
    window.addEventListener("keyup", (event) => this.key(event, false));
    window.addEventListener("blur", () => this.letGo());
    window.addEventListener("pagehide", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
    element("send-waypoints").addEventListener("click", () => this.sendWaypoints());
    element("undo-waypoint").addEventListener("click", () => this.change(() => this.waypoints.pop()));
    element("clear-waypoints").addEventListener("click", () => this.change(() => (this.waypoints = [])));
    element("legs").addEventListener("click", () => this.send({ do: "legs" }));
    const speed = element("key-speed");
    speed.addEventListener("input", () => this.showSpeed());
    this.choose("look");
  }

  get boats() {
    return this.state.scene?.boats;
  }

  get keySpeed() {
    return Number(element("key-speed").value) * this.boats.speed_max_m_s;
  }

  showSpeed() {
    if (this.boats) element("key-speed-value").textContent = `${(this.keySpeed * 1000).toFixed(0)} mm/s`;
  }

  change(act) {
    act();
    this.onChange();
  }

  choose(tool) {
    this.letGo();
    this.tool = tool;
    for (const button of document.querySelectorAll("[data-tool]")) {
      button.setAttribute("aria-pressed", String(button.dataset.tool === tool));
    }
    element("tool-help").textContent = HELP[tool];
    element("waypoint-buttons").hidden = tool !== "waypoints";
    this.onChange();
  }

  down(event) {
    this.camera.canvas.focus();
    if (this.tool === "look" || !this.can || !this.state.pose()) {
      this.camera.down(event);
      return;
    }
    this.camera.canvas.setPointerCapture(event.pointerId);
    this.drag = { id: event.pointerId, at: [event.offsetX, event.offsetY] };
    if (this.tool === "velocity") this.startRefreshing();
    this.onChange();
  }

  move(event) {
    if (this.drag?.id === event.pointerId) this.change(() => (this.drag.at = [event.offsetX, event.offsetY]));
    else this.camera.move(event);
  }

  up(event) {
    this.camera.up(event);
    if (this.drag?.id !== event.pointerId) return;
    const place = this.camera.toWorld(this.drag.at);
    const done = event.type === "pointerup";
    const { heading } = this;
    this.drag = null;
    if (this.tool === "velocity") this.letGo();
    else if (done && this.tool === "station") this.send({ do: "station", position_m: place, heading_rad: null });
    else if (done && this.tool === "heading" && heading !== null) this.send({ do: "heading", heading_rad: heading });
    else if (done && this.tool === "waypoints") this.waypoints.push(place);
    this.onChange();
  }

  key(event, isDown) {
    if (!(event.code in ARROWS)) return;
    // A release counts wherever the focus is by now, and with or without a connection.
    if (!isDown) {
      if (this.keys.delete(event.code) && !this.keys.size) this.letGo();
      return;
    }
    if (["INPUT", "SELECT"].includes(event.target.tagName) || !this.can || !this.boats) return;
    event.preventDefault();
    this.keys.add(event.code);
    this.startRefreshing();
  }

  /** The heading that is being dragged, rad, or null. */
  get heading() {
    const pose = this.state.pose();
    if (!this.drag || !pose) return null;
    const [east, north] = this.camera.toWorld(this.drag.at);
    const [dx, dy] = [east - pose.position_m[0], north - pose.position_m[1]];
    return Math.hypot(dx, dy) < 0.02 ? null : Math.atan2(dy, dx);
  }

  /** The velocity that is asked for now, m/s, or null. */
  get velocity() {
    const pose = this.state.pose();
    if (!this.boats) return null;
    if (this.keys.size) {
      const sum = [...this.keys].reduce(([x, y], code) => [x + ARROWS[code][0], y + ARROWS[code][1]], [0, 0]);
      const length = Math.hypot(...sum) || 1;
      return sum.map((part) => (part / length) * this.keySpeed);
    }
    if (!this.drag || !pose || this.tool !== "velocity") return null;
    const from = this.camera.toScreen(pose.position_m);
    const [dx, dy] = [this.drag.at[0] - from[0], from[1] - this.drag.at[1]];
    const shorten = Math.min(1, FULL_SPEED_PX / (Math.hypot(dx, dy) || 1)) / FULL_SPEED_PX;
    return [dx, dy].map((part) => part * shorten * this.boats.speed_max_m_s * 0.999);
  }

  startRefreshing() {
    this.refresh();
    this.timer ??= setInterval(() => this.refresh(), REFRESH_MS);
  }

  async refresh() {
    const velocity_m_s = this.velocity;
    if (!velocity_m_s) return;
    const answer = await this.connection.send({ do: "velocity", velocity_m_s, heading_rad: null });
    if (!answer.ok) this.orders.say(answer);
  }

  letGo() {
    this.keys.clear();
    if (this.tool === "velocity") this.drag = null;
    if (this.timer === null) return;
    clearInterval(this.timer);
    this.timer = null;
    this.send({ do: "let-go" });
  }

  async send(command) {
    this.orders.say(await this.connection.send(command));
  }

  async sendWaypoints() {
    const pose = this.state.pose();
    const path = pose ? [pose.position_m, ...this.waypoints] : this.waypoints;
    const outside = path.slice(1).findIndex((place, index) => !isInside(this.boats, path[index], place));
    if (outside >= 0) {
      this.orders.say({ ok: false, text: `the way to waypoint ${outside + 1} comes too near to the water's edge` });
      return;
    }
    const answer = await this.connection.send({ do: "waypoints", positions_m: this.waypoints, heading_rad: null });
    this.orders.say(answer);
    if (answer.ok) this.change(() => (this.waypoints = []));
  }

  /** What is drawn of a target that is not sent yet: places of a path. */
  get preview() {
    if (this.tool === "waypoints") return this.drag ? [...this.waypoints, this.camera.toWorld(this.drag.at)] : this.waypoints;
    return this.tool === "station" && this.drag ? [this.camera.toWorld(this.drag.at)] : null;
  }

  show(can, hasLegs) {
    this.can = can && this.connection.may;
    element("targets").hidden = !can;
    for (const button of element("targets").querySelectorAll("button, input")) button.disabled = !this.can;
    element("legs").disabled = !this.can || !hasLegs;
    element("send-waypoints").disabled = !this.can || !this.waypoints.length;
    this.showSpeed();
  }
}
