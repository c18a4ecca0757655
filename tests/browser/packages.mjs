// Fetches the packages of packages.json into FOLDER/node_modules and checks what they weigh: npm itself is not needed for two packages
// that depend on nothing.

import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdirSync, readFileSync } from "node:fs";

const [folder] = process.argv.slice(2);
for (const { name, url, integrity } of JSON.parse(readFileSync(new URL("packages.json", import.meta.url)))) {
  const reply = await fetch(url);
  if (!reply.ok) throw new Error(`${url}: ${reply.status} ${reply.statusText}`);
  const archive = Buffer.from(await reply.arrayBuffer());
  const is = `sha512-${createHash("sha512").update(archive).digest("base64")}`;
  if (is !== integrity) throw new Error(`${url}: ${is}, not ${integrity}`);
  const target = `${folder}/node_modules/${name}`;
  mkdirSync(target, { recursive: true });
  execFileSync("tar", ["--extract", "--gzip", "--strip-components=1", "--directory", target], { input: archive });
}
