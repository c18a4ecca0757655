// A person at a tank of three modules: looks, sends the structure to a station, drags a velocity and loses the page, stops by the space
// bar, releases, resumes. Judged by a socket of its own, on the fleet's clock.

import { check, DESKTOP, inBrowser, Listener, PHONE, pictures, shownPlace, until } from "./common.mjs";

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

await inBrowser(async (open) => {
  const judge = new Listener();
  await judge.opened;
  let page = await open();

  await until("three modules stand in the table and are ready", async () => (await page.locator('#modules tr[data-state="Ready"], #modules tr[data-state="Executing"], #modules tr[data-state="Holding"]').count()) === 3);
  await until("the page says that it may operate", async () => (await page.locator("#access").textContent()) === "may operate");
  await until("the page knows where the structure is", () => shownPlace(page));
  check(judge.scene.interactive && judge.latest.target.kind === "none", "a run without legs waits for a target");

  await station(page, judge);
  page = await lostPage(page, judge, open);
  await heldKey(page, judge);
  await emergencyStop(page, judge);

  await page.screenshot({ path: `${pictures}/console-desktop.png` });
  const phone = await open(undefined, { viewport: PHONE, colorScheme: "dark", hasTouch: true, isMobile: true });
  await until("a phone shows the fleet", () => shownPlace(phone));
  await phone.waitForTimeout(1000);
  const stop = await phone.locator("#stop").boundingBox();
  check(stop && stop.y + stop.height <= PHONE.height && stop.height >= 44, "the stop is in reach on a phone");
  check(await phone.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), "a phone's page is no wider than the phone");
  await phone.screenshot({ path: `${pictures}/console-phone.png` });
  await page.evaluate(() => (window.confirm = () => true));
  await page.locator("#end").click();
  await judge.until("the run is ended from the page", (snapshot) => snapshot.ended !== null);
});

async function station(page, judge) {
  const before = await shownPlace(page);
  await page.locator('[data-tool="station"]').click();
  const map = await page.locator("#top").boundingBox();
  await page.mouse.click(map.x + map.width / 2 + 60, map.y + map.height / 2 - 30);
  const { target } = await judge.until("the station is the target", (snapshot) => snapshot.target.kind === "station");
  check(target.from === "console" && distance(target.station_m, before) < 1, `the station ${target.station_m} is near the structure, ${before}`);
  const started = judge.latest;
  await judge.until("three modules swim", (snapshot) => snapshot.modules.every((module) => module.state === "Executing"));
  const tails = judge.latest.modules.map((module) => module.tail_rad);
  await judge.until("three tails move", (snapshot) => snapshot.modules.every((module, index) => Math.abs(module.tail_rad - tails[index]) > 0.2));
  // Tails turn to where the first cycle begins; with that cycle the log begins to tell where the structure is.
  const arrived = await judge.until("the structure arrives within 30 mm", ({ truth }) => truth !== null && distance(truth.position_m, target.station_m) < 0.03, 150_000);
  // A page draws when its machine lets it.
  await until("the page shows it there", async () => distance(await shownPlace(page), judge.latest.truth.position_m) < 0.03);
  console.log(`station of ${(distance(before, target.station_m) * 1000).toFixed(0)} mm reached after ${(arrived.fleet_s - started.fleet_s).toFixed(1)} s`);
}

/** Drags a velocity and closes the page: the fleet holds within 0.5 s. */
async function lostPage(page, judge, open) {
  await dragVelocity(page, judge);
  // A busy browser takes its time to close a page, which goes on as long.
  await page.context().close();
  const { n, fleet_s } = judge.latest;
  const held = await judge.until("a fleet whose page is gone holds", (snapshot) => snapshot.deadman !== null);
  const late = Math.max(0, held.fleet_s - fleet_s);
  console.log(`held ${late.toFixed(2)} s after the page was closed: ${held.deadman}; greatest gap between snapshots ${judge.stall(n).toFixed(0)} ms`);
  check(late <= 0.5 + judge.stall(n) / 1000, "that took no more than 0.5 s");
  const next = await open(undefined, { viewport: DESKTOP });
  await until("a new page may operate", async () => (await next.locator("#access").textContent()) === "may operate");
  return next;
}

/** Leaves the pointer down, with the structure swimming. */
async function dragVelocity(page, judge) {
  await page.locator('[data-tool="velocity"]').click();
  await until("the page knows where the structure is", () => shownPlace(page));
  const map = await page.locator("#top").boundingBox();
  await page.mouse.move(map.x + map.width / 2, map.y + map.height / 2);
  await page.mouse.down();
  // The map keeps the structure in its middle half: the right edge lies east of it.
  await page.mouse.move(map.x + map.width - 40, map.y + map.height / 2 - 20, { steps: 5 });
  await judge.until("the velocity is the target, and leads east", ({ target }) => target.kind === "velocity" && target.velocity_m_s[0] > 0.01);
  await judge.until("modules swim with it", (snapshot) => snapshot.modules.every((module) => module.state === "Executing"));
  await judge.until("the deadman is content while the pointer is held", (snapshot) => snapshot.deadman === null);
}

/** An arrow key that is released when something else has the focus: the fleet holds all the same. */
async function heldKey(page, judge) {
  await page.locator('[data-tool="look"]').click();
  await page.locator("#top").focus();
  await page.keyboard.down("ArrowUp");
  await judge.until("an arrow key swims north", ({ target }) => target.kind === "velocity" && target.velocity_m_s[1] > 0.01);
  await page.locator("#key-speed").focus();
  await page.keyboard.up("ArrowUp");
  await judge.until("its release holds, wherever the focus is", (snapshot) => snapshot.deadman === "let go" || snapshot.target.kind === "none");
  await page.locator("#top").focus();
}

/** The space bar while the structure swims: every drive is off within 0.3 s. */
async function emergencyStop(page, judge) {
  await dragVelocity(page, judge);
  // A busy browser takes its time to hand a key to the page.
  await page.evaluate(() => addEventListener("keydown", () => (window.pressed_ms = Date.now()), { capture: true, once: true }));
  await page.keyboard.press("Space");
  const pressed_ms = await page.evaluate(() => window.pressed_ms);
  const before = judge.snapshots.findLast((snapshot) => snapshot.came_ms <= pressed_ms);
  const stopped = await judge.until("every module is stopped", (snapshot) => snapshot.modules.every((module) => module.state === "Stopped"));
  const late = stopped.fleet_s - before.fleet_s;
  console.log(`stopped ${late.toFixed(2)} s after the key; greatest gap between snapshots ${judge.stall(before.n).toFixed(0)} ms`);
  // What is known of the key is the snapshot before it: 50 ms, or as long as the machine stalled.
  check(late <= 0.3 + Math.max(50, judge.stall(before.n)) / 1000, "that took no more than 0.3 s");
  await page.mouse.up();
  await until("the page says so", async () => (await page.locator("#alarms").textContent()).includes("Emergency stop"));
  // A braked tail runs on for some hundredths of a second, and is told of later.
  await page.waitForTimeout(500);
  const still = judge.latest.modules.map((module) => module.tail_rad);
  await page.waitForTimeout(1500);
  check(judge.latest.modules.every((module, index) => Math.abs(module.tail_rad - still[index]) < 0.1), "tails stay where they stopped");
  await page.locator("#release").click();
  await judge.until("released modules are ready", (snapshot) => snapshot.order === null && snapshot.modules.every((module) => module.state !== "Stopped"));
  await page.locator("#hold").click();
  await judge.until("hold is in force", (snapshot) => snapshot.order === "hold");
  await page.locator("#resume").click();
  await judge.until("resumed", (snapshot) => snapshot.order === null);
  await station(page, judge);
}
