// What the console does not do: take an order without the token, from another origin, or from a page on another port.

import http from "node:http";

import { address, check, host, inBrowser, Listener, until } from "./common.mjs";

const withoutToken = address.split("#")[0];

await inBrowser(async (open, wrong) => {
  const judge = new Listener();
  await judge.opened;
  await judge.until("the run goes on", (snapshot) => snapshot.modules.length === 3);

  const page = await open(withoutToken);
  await until("a page without the token only looks", async () => (await page.locator("#access").textContent()) === "looks only");
  await until("it shows the modules", async () => (await page.locator("#modules tr.row").count()) === 3);
  check(await page.locator("#stop").isDisabled(), "its stop button is off");
  await page.keyboard.press("Space");
  await until("its space bar says why", async () => (await page.locator("#answer").textContent()).includes("token"));

  judge.send({ id: 7, do: "stop" });
  await until("an order without the token is answered", () => judge.answers.length > 0);
  check(!judge.answers[0].ok, `it is refused: ${judge.answers[0].text}`);
  judge.send({ id: 8, do: "hello", token: "0".repeat(32) });
  await until("a wrong token is answered", () => judge.answers.length > 1);
  check(!judge.answers[1].ok, "a wrong token is refused");

  for (const origin of ["http://evil.example", "http://127.0.0.1:1", "null"]) {
    const stranger = new Listener({ origin });
    const refusal = await stranger.opened.then(() => null, (error) => error.message);
    check(refusal?.includes("403"), `origin ${origin} is refused: ${refusal}`);
  }
  const renamed = new Listener({ headers: { host: "evil.example" } });
  const refusal = await renamed.opened.then(() => null, (error) => error.message);
  check(refusal !== null, `another Host is refused: ${refusal}`);

  // A page on another port, which even knows the token.
  const elsewhere = http.createServer((_, reply) => reply.writeHead(200, { "content-type": "text/html" }).end("<!doctype html><title>elsewhere</title>"));
  await new Promise((resolve) => elsewhere.listen(0, "127.0.0.1", resolve));
  const other = await open(`http://127.0.0.1:${elsewhere.address().port}/`);
  const outcome = await other.evaluate(
    (where) =>
      new Promise((resolve) => {
        const socket = new WebSocket(`ws://${where}/socket`, "flotilla.console.v1");
        socket.onopen = () => resolve("open");
        socket.onerror = () => resolve("refused");
      }),
    host,
  );
  check(outcome === "refused", "a page on another port is refused");
  elsewhere.close();
  // The browser reports that refusal in the console of that page.
  wrong.splice(0, wrong.length, ...wrong.filter((text) => !text.includes("/socket") && !text.includes("favicon")));
  check(judge.latest.order === null && judge.latest.modules.every((module) => module.state !== "Stopped"), "after all that the fleet goes on");
});
