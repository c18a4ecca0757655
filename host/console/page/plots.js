// Wrench over the last minute, and the timeline of decisions.

import { canvasContext, clock, element, number } from "./format.js";
import { WINDOW_S } from "./state.js";

const AXES = ["sway N", "surge N", "yaw N m"];
const SERIES = ["demanded", "commanded", "achieved"];

export function showWrench(state, colours) {
  const { context, width, height } = canvasContext(element("wrench"));
  const now = state.snapshot.t_s;
  const each = height / AXES.length;
  context.font = "11px system-ui, sans-serif";
  AXES.forEach((axis, k) => {
    const values = state.wrenches.flatMap(([, ...series]) => series.filter(Boolean).map((wrench) => Math.abs(wrench[k])));
    const most = Math.max(1e-4, ...values) * 1.1;
    const middle = each * (k + 0.5);
    context.strokeStyle = colours.line;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(0, middle);
    context.lineTo(width, middle);
    context.stroke();
    SERIES.forEach((name, index) => {
      context.strokeStyle = colours[name];
      context.lineWidth = name === "demanded" ? 2 : 1.5;
      context.beginPath();
      let down = false;
      for (const [t, ...series] of state.wrenches) {
        const wrench = series[index];
        if (!wrench) {
          down = false;
          continue;
        }
        const at = [width - ((now - t) / WINDOW_S) * width, middle - (wrench[k] / most) * each * 0.45];
        if (down) context.lineTo(...at);
        else context.moveTo(...at);
        down = true;
      }
      context.stroke();
    });
    context.fillStyle = colours.quiet;
    context.fillText(`${axis}, ±${most.toPrecision(2)}`, 4, each * k + 12);
  });
}

const OUTCOMES = { planned: "hull", repeated: "trail", held: "quiet" };

export class Timeline {
  constructor(onChange) {
    this.canvas = element("timeline");
    this.hover = null;
    this.canvas.addEventListener("pointermove", (event) => {
      this.hover = event.offsetX;
      onChange();
    });
    this.canvas.addEventListener("pointerleave", () => {
      this.hover = null;
      onChange();
    });
  }

  show(state, colours) {
    const { context, width, height } = canvasContext(this.canvas);
    const now = state.snapshot.t_s;
    // A little of what is to come: decisions are sent ahead.
    const [begin, end] = [now - 40, now + 6];
    const x = (t) => ((t - begin) / (end - begin)) * width;
    let told = null;
    let latest = null;
    for (const decision of state.decisions.values()) {
      const finish = decision.start_s + decision.transition_s + decision.period_s;
      if (finish < begin || decision.start_s > end) continue;
      latest = decision;
      const [left, swing, right] = [decision.start_s, decision.start_s + decision.transition_s, finish].map(x);
      context.fillStyle = colours[OUTCOMES[decision.outcome] ?? "bad"];
      context.globalAlpha = 0.45;
      context.fillRect(left, 26, Math.max(swing - left - 1, 0), height - 66);
      context.globalAlpha = 1;
      context.fillRect(swing, 26, Math.max(right - swing - 1.5, 1), height - 66);
      const lacks = decision.missing.includes(true);
      if (decision.bounded || lacks) {
        context.fillStyle = lacks ? colours.bad : colours.warn;
        context.fillRect(left, 18, right - left - 1.5, 6);
      }
      context.fillStyle = decision.loss_tolerant ? colours.good : colours.warn;
      context.fillRect(left, height - 36, right - left - 1.5, 5);
      context.fillStyle = decision.power_tolerant ? colours.good : colours.warn;
      context.fillRect(left, height - 28, right - left - 1.5, 5);
      if (this.hover !== null && this.hover >= left && this.hover < right) told = decision;
    }
    context.strokeStyle = colours.ink;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x(now), 12);
    context.lineTo(x(now), height - 16);
    context.stroke();
    context.fillStyle = colours.quiet;
    context.font = "11px system-ui, sans-serif";
    for (let t = Math.ceil(begin / 10) * 10; t < end; t += 10) context.fillText(clock(t), x(t) + 2, height - 4);
    context.fillText("lower lines: tolerant of loss, of power loss", 4, 11);
    element("decision-text").textContent = words(told ?? latest, state.scene.modules);
  }
}

function words(decision, modules) {
  if (!decision) return "–";
  const absent = modules.filter((_, index) => decision.missing[index]);
  const more = [
    decision.reason,
    `error ${(decision.error * 100).toPrecision(2)} %`,
    decision.transition_s ? `transition ${number(decision.transition_s, 1)} s` : "no transition",
    absent.length ? `without ${absent.join(", ")}` : "",
    decision.bounded ? "cut at the water's edge" : "",
    `${decision.solve_us} µs`,
  ];
  return `${decision.number} at ${clock(decision.start_s)}: ${decision.outcome}, ${more.filter(Boolean).join(", ")}`;
}
