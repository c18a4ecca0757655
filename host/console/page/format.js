// Numbers and elements as the page writes them. What is not known is an en dash.

export const number = (value, digits = 2) =>
  value === null || value === undefined || !Number.isFinite(value) ? "–" : value.toFixed(digits).replace("-", "−");

export const degrees = (rad, digits = 0) => (rad === null || rad === undefined ? "–" : `${number((rad * 180) / Math.PI, digits)}°`);

/** Seconds as m:ss.s, with a sign below zero. */
export function clock(seconds) {
  if (seconds === null || seconds === undefined) return "–";
  const tenths = Math.round(Math.abs(seconds) * 10);
  const minutes = Math.floor(tenths / 600);
  const rest = ((tenths % 600) / 10).toFixed(1).padStart(4, "0");
  return `${seconds < 0 ? "−" : ""}${minutes}:${rest}`;
}

export const element = (id) => document.getElementById(id);

/** A new element with text or children. Text is never read as markup: names come from the network. */
export function make(tag, className, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  made.append(...children.map((child) => (child instanceof Node ? child : String(child))));
  return made;
}

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** All colours of a picture at once; read again when the system turns from light to dark. */
export function palette() {
  const names = ["ink", "quiet", "line", "hull", "tail", "trail", "target", "good", "warn", "bad", "demanded", "commanded", "achieved"];
  return Object.fromEntries(names.map((name) => [name, colour(name)]));
}

/** Fits a canvas to its box at the screen's own resolution, and gives its 2D context in CSS pixels. */
export function canvasContext(canvas) {
  const scale = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
