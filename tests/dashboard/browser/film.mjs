// SPDX-License-Identifier: Apache-2.0
// Films a drive on the page: film.mjs MODULES TANDEM SYSTEM CHROMIUM FOLDER
// A person holds the stick straight ahead although a pole stands there, and the robot goes round it.
// Writes FOLDER/<n>.png and FOLDER/frames, a list for ffmpeg with the time that each is shown. Time
// is that of the simulation, which runs slowly so that a busy machine keeps up. Exits with status 1 if the
// page reported a late message or a collision, so that a film always shows the same.
import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { startSystem, stick } from "./support.mjs";

const [modules, tandem, system, executablePath, folder] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");

const SPEED = 0.4; // simulated seconds in a second
const SIZE = { width: 960, height: 600 };
const START = [-4.3, -2.1, 0]; // 2.3 m before a pole, its middle a little to the left
const LAST = 1.2; // [m] x where the person lets go, between the next poles
const REST = 0.8; // [s] before the first and after the last motion
const LONG = 60_000; // [ms]

const { robot, port } = startSystem(tandem, system, [
  "-p", `diff_drive_sim:start:=[${START.join()}]`, "-p", `diff_drive_sim:speed_factor:=${SPEED}`,
]);
process.on("exit", () => robot.kill("SIGKILL"));
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const page = await (await browser.newContext({ viewport: SIZE })).newPage();
const until = (condition, argument) => page.waitForFunction(condition, argument, { timeout: LONG, polling: 20 });
const rest = () => page.waitForTimeout((1000 * REST) / SPEED);

await page.goto(`http://127.0.0.1:${await port}/`);
await until(() => window.tandem.robot.pose && window.tandem.robot.grid && window.tandem.robot.speed);
await page.getByText("Follow", { exact: true }).click();
await stick(page, 0, 0);

await page.evaluate(() => {
  window.notices = [];
  const toast = document.getElementById("toast");
  new MutationObserver(() => window.notices.push(toast.textContent)).observe(toast, { childList: true, characterData: true, subtree: true });
});

const frames = []; // { data, time [s] }
const session = await page.context().newCDPSession(page);
session.on("Page.screencastFrame", ({ data, metadata, sessionId }) => {
  frames.push({ data, time: metadata.timestamp });
  void session.send("Page.screencastFrameAck", { sessionId });
});
await session.send("Page.startScreencast", { format: "png", everyNthFrame: 4 });
await rest();
await page.mouse.down();
for (let push = 0.2; push <= 1; push += 0.1) await stick(page, push, 0);
await until((x) => window.tandem.robot.pose.x > x, LAST);
await page.mouse.up();
await until(() => Math.abs(window.tandem.robot.speed.v) < 0.02);
await rest();
await session.send("Page.stopScreencast");
const spoiled = await page.evaluate(() => window.notices.filter((text) => text));
if ((await page.locator("#collisions").textContent()) !== "0") spoiled.push("a collision");
await browser.close();

const list = frames.map(({ data, time }, i) => {
  writeFileSync(`${folder}/${i}.png`, Buffer.from(data, "base64"));
  const shown = i + 1 < frames.length ? frames[i + 1].time - time : 0.1 / SPEED;
  return `file ${i}.png\nduration ${(shown * SPEED).toFixed(4)}\n`;
});
writeFileSync(`${folder}/frames`, list.join(""));
console.log(`${frames.length} frames, ${((frames.at(-1).time - frames[0].time) * SPEED).toFixed(1)} s`);
if (spoiled.length) console.error(`The machine was too busy: ${spoiled.join("; ")}`);
process.exit(spoiled.length ? 1 : 0);
