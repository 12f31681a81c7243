// SPDX-License-Identifier: Apache-2.0
// Drives three tasks of a day with the page's stick: daily.mjs MODULES TANDEM ROOT CHROMIUM FOLDER [METHODS]
// The mouse in a real browser holds the stick, and steers by what the page shows: along a route with the leader, or
// with the robot where there is none. Prints a line for each drive and writes its last picture into FOLDER. Exits with
// status 1 after a contact, or if a robot does not end where it was steered to.
import { createRequire } from "node:module";
import { startSystem, stick } from "./support.mjs";

const [modules, tandem, root, executablePath, folder, methods = "leader,intention"] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");

const AHEAD = 0.5; // [m] along the route to the point that is steered to
const NEAR = 0.35; // [m] from a corner of the route: on to the next one
const CREEP = 0.15; // least push
const DONE = 0.02; // [m] from the end of the route
const LONGEST = 60; // [s] for a route
const OFF = 0.08; // [m] from the end of the route, once at rest
const STILL = 2.5; // [s]

// Those of bringup/scenarios/daily_*.yaml: routes of base_link [m]. The wheelchair's front is 0.6 m ahead of it, its side 0.325 m beside it.
const TASKS = [
  { name: "desk", start: [0.8, 2.4, 0], routes: [{ push: 0.6, via: [[0.8, 2.4], [2.2, 2.0], [3.33, 2.0]] }] },
  {
    name: "lift",
    start: [11.4, 5.4, 0],
    routes: [
      { push: 0.5, via: [[11.4, 5.4], [12.4, 5.05], [14.2, 5.05]] },
      { push: -0.4, via: [[14.2, 5.05], [11.8, 5.05]] },
    ],
  },
  { name: "bed", start: [8.95, 6.2, 0], routes: [{ push: 0.5, via: [[8.95, 6.2], [9.4, 6.3], [10.5, 6.775], [11.2, 6.775]] }] },
];

const distance = (p, [x, y]) => Math.hypot(x - p.x, y - p.y);
const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
const within = (value, most) => Math.max(-most, Math.min(most, value));

/** Where the hand holds the stick, `p` is what it steers, on the way from `from` to `to`; undefined at the end. */
function push(p, from, to, isLast, most) {
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const [ux, uy] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
  const along = (p.x - from[0]) * ux + (p.y - from[1]) * uy;
  const left = isLast ? length - along : Infinity;
  if (left < DONE) return undefined;
  const target = [from[0] + ux * (along + AHEAD), from[1] + uy * (along + AHEAD)];
  const facing = p.heading + (most < 0 ? Math.PI : 0);
  const error = wrapped(Math.atan2(target[1] - p.y, target[0] - p.x) - facing);
  const forward = Math.sign(most) * Math.min(Math.abs(most), Math.max(CREEP, left));
  return { forward, left: within(1.2 * error, 0.7) };
}

async function follow(page, method, route) {
  let next = 1;
  for (const end = Date.now() + 1000 * LONGEST; Date.now() < end; await page.waitForTimeout(40)) {
    const seen = await page.evaluate(() => ({ pose: window.tandem.robot.pose, leader: window.tandem.robot.get("leader_pose") }));
    const p = (method !== "intention" && seen.leader) || seen.pose;
    while (next < route.via.length - 1 && distance(p, route.via[next]) < NEAR) ++next;
    const hand = push(p, route.via[next - 1], route.via[next], next === route.via.length - 1, route.push);
    if (!hand) return;
    await stick(page, hand.forward, hand.left);
  }
}

async function drive(browser, task, method) {
  const map = `${root}/maps/home.bt`;
  const { robot, port } = startSystem(tandem, `${root}/bringup/systems/teleop.yaml`, [
    "--params-file", `${root}/bringup/robots/wheelchair.yaml`, "-p", `local_planner:method:=${method}`,
    "-p", `map_server:map:=${map}`, "-p", `diff_drive_sim:map:=${map}`, "-p", `diff_drive_sim:start:=[${task.start.join()}]`,
  ]);
  try {
    const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 } })).newPage();
    await page.goto(`http://127.0.0.1:${await port}/`);
    await page.waitForFunction(() => window.tandem.robot.pose && window.tandem.robot.grid && window.tandem.robot.speed);
    await page.getByText("Follow", { exact: true }).click();
    const begin = Date.now();
    await stick(page, 0, 0);
    await page.mouse.down();
    await page.waitForTimeout(500); // a stick must be seen at rest first
    for (const route of task.routes) {
      await follow(page, method, route);
      await stick(page, 0, 0);
      await page.waitForTimeout(1000 * STILL);
    }
    await page.screenshot({ path: `${folder}/${task.name}_${method}.png` });
    const pose = await page.evaluate(() => window.tandem.robot.pose);
    const contacts = await page.locator("#collisions").textContent();
    const off = distance(pose, task.routes.at(-1).via.at(-1));
    const time = ((Date.now() - begin) / 1000).toFixed(1);
    console.log(`${task.name} by ${method}: ${time} s, ${off.toFixed(3)} m off, contacts ${contacts}`);
    return contacts === "0" && off < OFF;
  } finally {
    robot.kill("SIGKILL");
  }
}

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
let good = true;
for (const method of methods.split(",")) for (const task of TASKS) good = (await drive(browser, task, method)) && good;
await browser.close();
process.exit(good ? 0 : 1);
