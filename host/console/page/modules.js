// The tables: modules of the fleet (details on a click), ROVs with their thrusters, and the moves of a plan.

import { clock, degrees, element, make, number } from "./format.js";
import { isUnderWay } from "./rovs.js";

const STATES = { Executing: "good", Ready: "good", Holding: "warn", Arming: "warn", Unsynchronised: "warn", Boot: "warn", Unprovisioned: "bad", Stopped: "bad" };

/** Columns of words, not of figures. */
const TEXTS = new Set(["state", "thrusters", "docked off by"]);
const head = (...titles) => make("thead", "", make("tr", "", ...titles.map((title) => make("th", TEXTS.has(title) ? "text" : "", title))));
const cell = (text, className) => make("td", className, text);

export class Modules {
  constructor(orders) {
    this.orders = orders;
    this.opened = new Set();
    element("modules").addEventListener("click", (event) => this.click(event));
  }

  click({ target }) {
    if (target.dataset.release) {
      this.orders.order("release", { module: Number(target.dataset.release) });
      return;
    }
    const id = target.closest("tr.row")?.dataset.id;
    if (!id) return;
    if (!this.opened.delete(id)) this.opened.add(id);
    this.drawn = 0;
  }

  /** Five times a second is as fast as numbers can be read, and leaves a click its target. */
  show(state) {
    const now = performance.now();
    if (now - (this.drawn ?? 0) < 200) return;
    this.drawn = now;
    const { modules, robots } = state.snapshot;
    const table = element("modules");
    const body = make("tbody", "");
    for (const module of modules ?? []) {
      const robot = robots?.find(({ id }) => id === module.id);
      body.append(robot ? robotRow(module, robot) : moduleRow(module));
      if (this.opened.has(String(module.id))) body.append(details(module, robot));
    }
    const titles = robots
      ? ["robot", "state", "thrusters", "power W", "battery V", "link %"]
      : ["module", "state", "battery V", "link %", "clock ms", "tail", "error mrad"];
    table.replaceChildren(head(...titles), body);
    const well = (modules ?? []).filter((module) => STATES[module.state] === "good" && !module.faults.length && !module.stale).length;
    element("modules-title").textContent = `${robots ? "Robots" : "Modules"}: ${well} of ${(modules ?? []).length} well`;
  }
}

function row(module) {
  const made = make("tr", "row");
  made.dataset.id = module.id;
  made.dataset.state = module.state ?? "unheard";
  made.append(cell(module.id), cell(word(module), `text ${mark(module)}`));
  return made;
}

const word = (module) => (module.silent_s === null ? "not heard" : module.stale ? `silent ${number(module.silent_s, 1)} s` : module.faults[0] ?? module.state ?? "–");
const mark = (module) => (module.stale || module.faults.length || module.state === null ? "bad" : STATES[module.state] ?? "warn");
const share = ({ delivered }) => (delivered === null ? cell("–") : cell((delivered * 100).toFixed(0), delivered < 0.5 ? "bad" : delivered < 0.8 ? "warn" : "good"));

function moduleRow(module) {
  const made = row(module);
  const error = module.tail_error_rad;
  made.append(
    cell(number(module.battery_v, 2)),
    share(module),
    cell(number(module.clock_us === null ? null : module.clock_us / 1000, 2)),
    cell(degrees(module.tail_rad)),
    cell(number(error === null ? null : error * 1000, 0), Math.abs(error ?? 0) > 0.02 ? "bad" : ""),
  );
  return made;
}

function robotRow(module, robot) {
  const made = row(module);
  const bars = make("span", "bars");
  robot.pulses_us?.forEach((pulse, index) => {
    const bar = make("span", "");
    const fill = make("i", "");
    const part = Math.max(-1, Math.min(1, (pulse - 1500) / 400));
    fill.style.top = `${50 - Math.max(part, 0) * 50}%`;
    fill.style.height = `${Math.abs(part) * 50}%`;
    bar.title = `thruster ${index + 1}: ${pulse} µs, ${number(robot.thrusts_n?.[index], 1)} N`;
    bar.append(fill);
    bars.append(bar);
  });
  made.append(make("td", "text", bars), cell(number(robot.power_w, 1)), cell(number(module.battery_v, 2)), share(module));
  return made;
}

function details(module, robot) {
  const lines = [
    `heard ${number(module.silent_s, 2)} s ago`,
    `answers within ${number(module.answer_ms, 0)} ms (median)`,
    `clock within ${number(module.clock_us, 0)} µs`,
    module.faults.length ? `faults: ${module.faults.join(", ")}` : "no faults",
  ];
  if (robot) {
    lines.push(`at ${robot.position_m.map((at) => number(at, 2)).join(", ")} m`, `roll, pitch, yaw ${robot.attitude_rad.map((at) => degrees(at)).join(", ")}`);
    lines.push(`pulses ${robot.pulses_us?.join(", ") ?? "–"} µs`);
  }
  const release = make("button", "", "release this one");
  release.type = "button";
  release.dataset.release = module.id;
  release.disabled = module.state !== "Stopped";
  const inside = make("td", "", lines.join(" · "), " ", release);
  inside.colSpan = 7;
  return make("tr", "details", inside);
}

/** Moves of ROVs with energy so far against plan. */
export function showMoves(state) {
  const { plan } = state.scene.rovs ?? {};
  element("energy").hidden = !plan;
  if (!plan) return;
  const { moves } = state.snapshot;
  const rows = plan.moves.map((move, index) => {
    const done = moves?.done[index];
    const now = isUnderWay(moves, index);
    const made = make("tr", now ? "warn" : "");
    made.append(cell(move.robot), cell(move.slot === null ? "parks" : move.slot + 1), cell(clock(done?.time_s ?? null)), cell(number(move.energy_j, 1)), cell(number(done?.executed_j, 1)));
    made.append(cell(now ? "under way" : done ? `${number(done.end_m * 1000, 0)} mm, ${degrees(done.end_rad, 1)}` : "", "text"));
    return made;
  });
  const total = make("tr", "", cell("all"), cell(""), cell(""), cell(number(moves?.planned_j ?? plan.energy_total_j, 1)), cell(number(moves?.executed_j, 1)), cell(""));
  element("moves").replaceChildren(head("robot", "slot", "took", "planned J", "drawn J", "docked off by"), make("tbody", "", ...rows, total));
}
