// What the scripts share: the browser, a socket that only listens, and how to wait.
//
// Every script is called with the address that the program printed and a folder for pictures, and ends with 1 when something is not as
// it must be. Packages are looked for in the folder that FLOTILLA_BROWSER names.

import { createRequire } from "node:module";

const require = createRequire(`${process.env.FLOTILLA_BROWSER}/`);
const { chromium } = require("playwright-core");
export const { WebSocket } = require("ws");

export const [address, pictures] = process.argv.slice(2);
export const { host } = new URL(address);
export const DESKTOP = { width: 1400, height: 1000 };
export const PHONE = { width: 390, height: 844 };

const PATIENCE_MS = 60_000;

export function check(holds, what) {
  if (!holds) throw new Error(what);
  console.log(`ok: ${what}`);
}

export async function until(what, asked, patience = PATIENCE_MS) {
  const end = Date.now() + patience;
  for (;;) {
    const found = await asked();
    if (found) {
      console.log(`ok: ${what}`);
      return found;
    }
    if (Date.now() > end) throw new Error(`waited ${patience / 1000} s in vain: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** A socket to the console that keeps what it hears; it has no token. */
export class Listener {
  constructor(options = {}) {
    this.snapshots = [];
    this.scene = null;
    this.answers = [];
    this.socket = new WebSocket(`ws://${host}/socket`, "flotilla.console.v1", options);
    this.opened = new Promise((resolve, reject) => {
      this.socket.on("open", resolve);
      this.socket.on("error", reject);
    });
    this.socket.on("message", (data) => {
      const message = JSON.parse(data);
      if (message.kind === "snapshot") this.snapshots.push({ ...message, came_ms: Date.now() });
      if (message.kind === "scene") this.scene = message;
      if (message.kind === "answer") this.answers.push(message);
    });
  }

  get latest() {
    return this.snapshots.at(-1);
  }

  send(command) {
    this.socket.send(JSON.stringify(command));
  }

  /** Waits for a snapshot of which `holds` is true. */
  until(what, holds, patience) {
    return until(what, () => this.latest && holds(this.latest) && this.latest, patience);
  }

  /** The longest that no snapshot came since `n`, ms: what the machine stalled for. */
  stall(n) {
    const came = this.snapshots.filter((snapshot) => snapshot.n >= n).map((snapshot) => snapshot.came_ms);
    return Math.max(0, ...came.slice(1).map((at, index) => at - came[index]));
  }
}

/** Runs a script in a browser, and refuses errors of the page. */
export async function inBrowser(script) {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
  const wrong = [];
  const open = async (where = address, options = {}) => {
    const context = await browser.newContext({ viewport: DESKTOP, ...options });
    const page = await context.newPage();
    page.on("pageerror", (error) => wrong.push(error.message));
    page.on("console", (message) => message.type() === "error" && wrong.push(message.text()));
    await page.goto(where);
    return page;
  };
  try {
    await script(open, wrong);
    check(wrong.length === 0, `no error in the page's console ${wrong.join("; ")}`);
  } finally {
    await browser.close();
  }
  // Sockets of judges would keep the script until the run is over.
  process.exit(0);
}

/** Position that the page shows, m. */
export async function shownPlace(page) {
  const text = await page.locator("#top-legend").textContent();
  const found = text.match(/at ([−\d.]+), ([−\d.]+) m/);
  return found?.slice(1).map((value) => Number(value.replace("−", "-")));
}
