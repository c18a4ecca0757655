// The page: takes what the server says, and draws it once a frame when something has changed.

import * as boats from "./boats.js";
import { Camera, grid } from "./camera.js";
import { Connection } from "./connection.js";
import { arrow } from "./draw.js";
import { canvasContext, clock, degrees, element, make, number, palette } from "./format.js";
import { Modules, showMoves } from "./modules.js";
import { Orders } from "./orders.js";
import { Player } from "./player.js";
import { Timeline, showWrench } from "./plots.js";
import * as rovs from "./rovs.js";
import { State } from "./state.js";
import { Steer } from "./steer.js";

const state = new State();
let dirty = false;
let colours = palette();
let eventsShown = null;
draw.fitted = false;

const redraw = () => {
  if (dirty) return;
  dirty = true;
  requestAnimationFrame(draw);
};

const connection = new Connection(
  (message) => {
    if (state.take(message) === "scene") draw.fitted = false;
    redraw();
  },
  () => redraw(),
);
const orders = new Orders(connection);
const camera = new Camera(element("top"), redraw);
const side = new Camera(element("side"), redraw);
const steer = new Steer(connection, orders, camera, state, redraw);
const modules = new Modules(orders);
const player = new Player(connection, orders);
const timeline = new Timeline(redraw);

function fit() {
  if (!state.scene) return;
  camera.chosen = false;
  camera.follow = true;
  if (state.scene.boats) camera.fit(boats.extent(state));
  else camera.fit(rovs.extent(state, rovs.above));
}

element("fit").addEventListener("click", fit);
element("zoom-in").addEventListener("click", () => camera.zoom(1.4));
element("zoom-out").addEventListener("click", () => camera.zoom(1 / 1.4));
element("follow").addEventListener("click", () => {
  camera.follow = !camera.follow;
  redraw();
});
window.addEventListener("keydown", ({ code, target }) => {
  if (target.tagName === "INPUT") return;
  if (code === "KeyF") camera.follow = !camera.follow;
  if (code === "Digit0") fit();
  redraw();
});
window.addEventListener("resize", redraw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colours = palette();
  redraw();
});

function draw() {
  dirty = false;
  showHead();
  const { scene, snapshot } = state;
  if (!scene || !snapshot) return;
  // A scene that came before the first pose waits until the fleet is seen.
  if (!draw.fitted && (state.pose() || snapshot.robots)) {
    draw.fitted = true;
    if (!camera.chosen) camera.fit(scene.boats ? boats.surroundings(state) : rovs.extent(state, rovs.above));
  }
  orders.show(snapshot, scene.can);
  steer.show(scene.can.steer, Boolean(scene.boats?.legs.length));
  player.show(snapshot.play, connection.may);
  if (scene.boats) drawBoats();
  else drawRovs();
  modules.show(state);
  showMoves(state);
  element("wrench-figure").hidden = !scene.boats;
  element("timeline-figure").hidden = !scene.boats;
  if (scene.boats) {
    showWrench(state, colours);
    timeline.show(state, colours);
  }
  showPoses();
  showEvents();
}

function drawBoats() {
  const pose = state.pose();
  if (pose && camera.follow) camera.keepInView(pose.position_m);
  const { context } = canvasContext(camera.canvas);
  grid(context, camera, colours);
  boats.draw(context, camera, state, colours, steer.preview);
  const { velocity, heading } = steer;
  if (pose && velocity) {
    const full = boats.FULL_SPEED_PX / state.scene.boats.speed_max_m_s;
    arrow(context, camera.toScreen(pose.position_m), [velocity[0] * full, -velocity[1] * full], colours.target, 4);
  }
  if (pose && steer.tool === "heading" && heading !== null) {
    arrow(context, camera.toScreen(pose.position_m), [Math.cos(heading) * 90, -Math.sin(heading) * 90], colours.target, 4);
  }
  const speed = pose?.velocity_m_s ? `${number(Math.hypot(...pose.velocity_m_s) * 1000, 0)} mm/s` : "";
  element("top-legend").textContent = pose
    ? `at ${pose.position_m.map((at) => number(at)).join(", ")} m, heading ${degrees(pose.heading_rad, 1)} ${speed}`
    : "no pose yet";
  element("target").textContent = words(state.snapshot.target);
}

function drawRovs() {
  element("side-view").hidden = false;
  const top = canvasContext(camera.canvas).context;
  grid(top, camera, colours);
  rovs.draw(top, camera, state, colours, rovs.above);
  // The same east and the same scale as above, as far as the depths fit in.
  side.scale = camera.scale;
  const depths = rovs.extent(state, rovs.aside).map(([, up]) => up);
  side.centre = [camera.centre[0], (Math.min(...depths) + Math.max(...depths)) / 2];
  const below = canvasContext(side.canvas).context;
  grid(below, side, colours, (up) => -up);
  rovs.draw(below, side, state, colours, rovs.aside);
  const { moves } = state.snapshot;
  element("top-legend").textContent = moves ? `${number(moves.executed_j, 1)} J drawn, ${number(moves.planned_j, 1)} J planned` : "";
}

function words(target) {
  if (!target || target.kind === "none") return "no target: waits for one";
  const heading = target.heading_rad === null ? "" : `, heading ${degrees(target.heading_rad)}`;
  const place = (at) => at.map((value) => number(value)).join(", ");
  const what = {
    velocity: () => `velocity ${target.velocity_m_s.map((value) => number(value * 1000, 0)).join(", ")} mm/s`,
    station: () => `station ${place(target.station_m)} m`,
    waypoints: () => `${target.waypoints_m.length} waypoints, next ${place(target.waypoints_m[0] ?? [NaN, NaN])} m`,
  };
  return `${what[target.kind]()}${heading} (from ${target.from === "leg" ? "the scenario" : "the console"})`;
}

function showHead() {
  const { scene, snapshot } = state;
  element("name").textContent = scene?.name ?? "Flotilla";
  document.title = scene ? `${scene.name} – Flotilla` : "Flotilla";
  element("clock").textContent = clock(snapshot?.t_s ?? null);
  element("status").textContent = connection.isOpen ? snapshot?.status ?? "waiting for the run" : "not connected";
  element("follow").setAttribute("aria-pressed", String(camera.follow));
  const access = element("access");
  access.hidden = !connection.isOpen;
  access.className = connection.may ? "badge good" : "badge";
  access.textContent = connection.may ? "may operate" : "looks only";
  const link = element("link");
  link.className = connection.isOpen ? "badge" : "badge bad";
  link.textContent = connection.isOpen ? `${state.rate().toFixed(0)} a second, ${snapshot?.dropped ?? 0} dropped` : "no connection";
  const alarms = [];
  const alarm = (text, className = "") => alarms.push(make("p", className, text));
  if (!connection.isOpen) alarm("Not connected to the run. A stop from this page would not be sent: use flotilla stop.", "pulse");
  if (snapshot && connection.isOpen) {
    if (snapshot.ended !== null) alarm(`The run is over${snapshot.ended ? `: ${snapshot.ended}` : ""}.`, "warn");
    if (snapshot.order === "stop") alarm("Emergency stop: every drive is off until a release.");
    if (snapshot.order === "hold") alarm("The fleet holds until resume.", "warn");
    if (snapshot.deadman) alarm(`The fleet holds: ${snapshot.deadman}. A new target goes on.`, "warn");
    if (snapshot.poses?.trouble) alarm(`Poses: ${snapshot.poses.trouble}`);
  }
  const shown = element("alarms");
  if (shown.textContent !== alarms.map((made) => made.textContent).join("")) shown.replaceChildren(...alarms);
}

function showPoses() {
  const { poses, fix } = state.snapshot;
  element("poses-section").hidden = !poses?.source;
  if (!poses?.source) return;
  const used = poses.bodies.filter((body) => body.used).length;
  const age = fix ? `newest fix ${number(fix.age_s * 1000, 0)} ms old` : "no fix yet";
  const late = poses.late_p50_s === null ? "" : `, late by ${number(poses.late_p50_s * 1000, 0)} ms`;
  const bodies = poses.bodies.length ? `, ${used} of ${poses.bodies.length} bodies used` : "";
  element("poses").textContent = `${poses.source}: ${poses.frames_accepted} of ${poses.frames} frames taken${late}${bodies}; ${age}`;
}

function showEvents() {
  const newest = state.events.at(-1);
  const key = `${state.events.length} ${newest?.fleet_s} ${newest?.text}`;
  if (key === eventsShown) return;
  eventsShown = key;
  const lines = state.events.slice(-200).reverse().map((event) => {
    const who = event.module === null || event.module === undefined ? "" : `module ${event.module}: `;
    return make("li", event.sort, make("time", "", clock(event.t_s)), make("span", "", who + event.text));
  });
  element("events").replaceChildren(...lines);
}

redraw();
