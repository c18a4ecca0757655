// The part of the water that a canvas shows: east to the right, north up, one scale for both axes.
// Drag pans, wheel and pinch zoom, unless a tool has taken the pointer.

export class Camera {
  constructor(canvas, onMove) {
    this.canvas = canvas;
    this.onMove = onMove;
    this.centre = [0, 0];
    /** Pixels per metre. */
    this.scale = 200;
    this.follow = true;
    /** Whether the user has chosen the scale. */
    this.chosen = false;
    this.pointers = new Map();
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  toScreen([east, north]) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [width / 2 + (east - this.centre[0]) * this.scale, height / 2 - (north - this.centre[1]) * this.scale];
  }

  toWorld([x, y]) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [this.centre[0] + (x - width / 2) / this.scale, this.centre[1] - (y - height / 2) / this.scale];
  }

  /** Shows all of `points` ([east, north] in m) with a margin. */
  fit(points) {
    if (!points.length) return;
    const low = [0, 1].map((k) => Math.min(...points.map((point) => point[k])));
    const high = [0, 1].map((k) => Math.max(...points.map((point) => point[k])));
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const span = [0, 1].map((k) => Math.max(high[k] - low[k], 0.5));
    this.centre = [0, 1].map((k) => (low[k] + high[k]) / 2);
    this.scale = 0.86 * Math.min(width / span[0], height / span[1]);
    this.onMove();
  }

  /** Keeps a place inside the middle of the canvas. */
  keepInView(place) {
    const [x, y] = this.toScreen(place);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const over = (at, size) => Math.min(0, at - 0.25 * size) + Math.max(0, at - 0.75 * size);
    this.centre[0] += over(x, width) / this.scale;
    this.centre[1] -= over(y, height) / this.scale;
  }

  zoom(factor, about = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]) {
    const fixed = this.toWorld(about);
    this.scale = Math.min(Math.max(this.scale * factor, 1e-3), 5000);
    const moved = this.toWorld(about);
    this.centre = [0, 1].map((k) => this.centre[k] + fixed[k] - moved[k]);
    this.chosen = true;
    this.onMove();
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(Math.exp(-event.deltaY / 400), [event.offsetX, event.offsetY]);
  }

  down(event) {
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.canvas.setPointerCapture(event.pointerId);
  }

  /** One pointer pans; two zoom about their middle. */
  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.pointers.set(event.pointerId, now);
    if (others.length) {
      const apart = (place) => Math.hypot(place[0] - others[0][0], place[1] - others[0][1]);
      this.zoom(apart(now) / Math.max(apart(before), 1), others[0]);
      return;
    }
    this.centre[0] -= (now[0] - before[0]) / this.scale;
    this.centre[1] += (now[1] - before[1]) / this.scale;
    this.follow = false;
    this.onMove();
  }

  up(event) {
    this.pointers.delete(event.pointerId);
  }
}

/** Draws a grid of metres; `up` says how the upward axis is written. */
export function grid(context, camera, colours, up = (value) => value) {
  const { clientWidth: width, clientHeight: height } = camera.canvas;
  const rough = 70 / camera.scale;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= rough);
  const [west, north] = camera.toWorld([0, 0]);
  const [east, south] = camera.toWorld([width, height]);
  context.lineWidth = 1;
  context.strokeStyle = colours.line;
  context.fillStyle = colours.quiet;
  context.font = "11px system-ui, sans-serif";
  context.beginPath();
  const label = (value) => String(Number(value.toPrecision(12))).replace("-", "−");
  for (let k = Math.ceil(west / step); k * step <= east; k += 1) {
    const [x] = camera.toScreen([k * step, 0]);
    context.moveTo(x, 0);
    context.lineTo(x, height);
    context.fillText(label(k * step), x + 3, height - 4);
  }
  for (let k = Math.ceil(south / step); k * step <= north; k += 1) {
    const [, y] = camera.toScreen([0, k * step]);
    context.moveTo(0, y);
    context.lineTo(width, y);
    if (y < height - 18) context.fillText(label(up(k * step)), 3, y - 3);
  }
  context.stroke();
  context.fillText("m", width - 14, height - 4);
}
