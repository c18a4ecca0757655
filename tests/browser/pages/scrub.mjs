// A log in the browser: play, pause, scrub, speed.

import { check, inBrowser, Listener, pictures, shownPlace, until } from "./common.mjs";

await inBrowser(async (open) => {
  const judge = new Listener();
  await judge.opened;
  const page = await open();
  await until("the page shows the player", () => page.locator("#player").isVisible());
  check(!(await page.locator("#orders").isVisible()), "there is no fleet to give orders to");
  const seek = async (share) => {
    const { begin_s, end_s } = judge.latest.play;
    const at = begin_s + share * (end_s - begin_s);
    await page.locator("#scrub").evaluate((scrub, value) => {
      scrub.value = value;
      scrub.dispatchEvent(new Event("input", { bubbles: true }));
      scrub.dispatchEvent(new Event("change", { bubbles: true }));
    }, at);
    await judge.until(`the log is at ${at.toFixed(1)} s`, (snapshot) => Math.abs(snapshot.play.at_s - at) < 2);
  };
  if (judge.latest?.play.playing ?? (await judge.until("it plays", (snapshot) => snapshot.play)).play.playing) {
    await page.locator("#play").click();
    await judge.until("paused", (snapshot) => !snapshot.play.playing);
  }
  await seek(0.2);
  const early = await until("the page shows where the structure was", () => shownPlace(page));
  await seek(0.9);
  await until("and where it was later", async () => {
    const late = await shownPlace(page);
    return late && Math.hypot(late[0] - early[0], late[1] - early[1]) > 0.1;
  });
  await page.screenshot({ path: `${pictures}/console-log.png` });
  await seek(0.1);
  await page.locator("#speed").selectOption("10");
  await judge.until("the speed is ten", (snapshot) => snapshot.play.speed === 10);
  const from = judge.latest.play.at_s;
  await page.locator("#play").click();
  await judge.until("ten seconds are played", (snapshot) => snapshot.play.at_s > from + 10);
});
