// SPDX-License-Identifier: Apache-2.0
// Drives two robots in a real browser: browser_test.mjs MODULES TANDEM SYSTEMS CHROMIUM [PICTURES]
// Two robots share a domain. On one, which is in a namespace, a person takes the user test with the stick
// on the screen and with the keyboard. At the same time the other is driven in every view and by every
// input device, stopped in an emergency, cut off from the network, and taken over by another page.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import net from "node:net";
import { tmpdir } from "node:os";
import { setTimeout as pause } from "node:timers/promises";
import { startSystem, stick } from "./support.mjs";

const [modules, tandem, systems, executablePath, pictures] = process.argv.slice(2);
const { chromium } = createRequire(`${modules}/`)("playwright-core");

// Constants of tandem_msgs/ReasonCode by name.
const definition = readFileSync(new URL("../../../idl/tandem_msgs/msg/ReasonCode.msg", import.meta.url), "utf8");
const ReasonCode = Object.fromEntries([...definition.matchAll(/^uint8 (\w+)=(\d+)$/gm)].map(([, name, value]) => [name, Number(value)]));

const LONG = 60_000; // [ms] for a slow machine
const STANDS = 0.02; // [m/s]

// --- the robots --------------------------------------------------------------------------------
const results = mkdtempSync(`${tmpdir()}/tandem_browser_`);
const robots = [];
process.on("exit", () => {
  for (const robot of robots) robot.kill("SIGKILL");
  rmSync(results, { recursive: true });
});

/** Starts a system, with ROS arguments; gives back the port of its page. */
function start(system, ...args) {
  const { robot, port } = startSystem(tandem, `${systems}/${system}.yaml`, args);
  robots.push(robot);
  return port;
}

// The user test starts half way to the region.
const START = [1.6, -1.9, 1.3];
const apart = ["__ns:=/robot1", "/tf:=tf", "/clock:=clock"].flatMap((r) => ["-r", r]);
const TOKEN = "a-token-of-the-test";
writeFileSync(`${results}/token`, TOKEN);
const testParameters = [`dashboard:user_tests:=${results}`, `dashboard:token_file:=${results}/token`, `diff_drive_sim:start:=[${START.join()}]`];
// The joystick has other axis and button numbers, and a reversed axis.
const otherJoystick = ["axis_linear:=4", "deadman_button:=5", "scale_linear:=-0.8", "leader_scale_linear:=-0.9"].flatMap((p) => ["-p", `teleop:${p}`]);
const [address, testAddress] = await Promise.all([
  start("teleop", ...otherJoystick),
  start("user_test", ...apart, ...testParameters.flatMap((p) => ["-p", p])),
]);

// --- a network that can be cut -----------------------------------------------------------------
const wires = new Set();
let whole = true;
const join = ([near, far]) => near.pipe(far).pipe(near);
const network = net.createServer((near) => {
  const far = net.connect(address, "127.0.0.1"), wire = [near, far];
  for (const end of wire) {
    end.on("error", () => {});
    end.on("close", () => whole && wires.delete(wire) && wire.forEach((other) => other.destroy()));
  }
  wires.add(wire);
  if (whole) join(wire);
});
await new Promise((resolve) => network.listen(0, "127.0.0.1", resolve));
const through = network.address().port;
function cut() {
  whole = false;
  for (const [near, far] of wires) near.unpipe(far), far.unpipe(near);
}
function mend() {
  whole = true;
  wires.forEach(join);
}

// --- the browser -------------------------------------------------------------------------------
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });

async function open(port, viewport, query = "") {
  const page = await (await browser.newContext({ viewport })).newPage();
  page.on("pageerror", (error) => assert.fail(`the page fails: ${error}`));
  const start = Date.now();
  await page.goto(`http://127.0.0.1:${port}/${query}`);
  const loaded = Date.now() - start;
  const paint = await (await until(page, () => performance.getEntriesByName("first-contentful-paint")[0]?.startTime)).jsonValue();
  console.log(`loaded in ${loaded} ms, first paint ${paint.toFixed(0)} ms`);
  assert.ok(paint < 5000, "nothing is seen for long"); // a second on a machine that does nothing else
  await until(page, () => window.tandem.robot.pose && window.tandem.robot.grid && window.tandem.robot.speed);
  return page;
}
const until = (page, condition, argument) =>
  page.waitForFunction(condition, argument, { timeout: LONG, polling: 50 });
const gives = (page, code) =>
  until(page, (c) => window.tandem.robot.get("arbitration/status")?.reason_code.value === c, code);
const pose = (page) => page.evaluate(() => window.tandem.robot.pose);
const speed = (page) => page.evaluate(() => Math.abs(window.tandem.robot.speed?.v ?? NaN));
const moves = (page) => until(page, () => Math.abs(window.tandem.robot.speed?.v ?? 0) > 0.2);
const stands = (page, still) => until(page, (s) => Math.abs(window.tandem.robot.speed?.v ?? 1) < s, still ?? STANDS);
const picture = (page, name) => (pictures ? page.screenshot({ path: `${pictures}/${name}.png` }) : undefined);
const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

const LAPTOP = { width: 1280, height: 800 }, PHONE = { width: 390, height: 844 };
const [page, watcher, testPage] = await Promise.all([
  open(through, LAPTOP),
  open(address, PHONE),
  open(testAddress, PHONE, `?user_test=1,1,0&token=${TOKEN}`), // seconds: practice, task 1, countdown
]);

async function step(name, run) {
  const start = Date.now();
  try {
    await run();
  } catch (error) {
    await Promise.all([page, watcher, testPage].filter((each) => !each.isClosed()).map(report));
    throw new Error(name, { cause: error });
  }
  console.log(`${name}: ${((Date.now() - start) / 1000).toFixed(1)} s`);
}

async function report(page) {
  const texts = await page.evaluate(() =>
    ["banner", "toast", "connection", "user-test"].map((id) => document.getElementById(id).textContent.trim()));
  console.log(page.url(), texts);
}

// --- hands --------------------------------------------------------------------------------------
const stickOf = (page) => ({
  hold: async () => (await stick(page, 0, 0), await page.mouse.down()),
  steer: (turn) => stick(page, Math.max(0, Math.cos(turn)), Math.max(-1, Math.min(1, 1.5 * turn))),
  letGo: () => page.mouse.up(),
});
const keysOf = (page) => ({
  key: "",
  hold: async () => {},
  async steer(turn) {
    const key = Math.abs(turn) < 0.15 ? "i" : Math.abs(turn) > 1 ? (turn > 0 ? "j" : "l") : turn > 0 ? "u" : "o";
    if (key === this.key) return;
    await page.keyboard.down(key);
    await this.letGo();
    this.key = key;
  },
  async letGo() {
    if (this.key) await page.keyboard.up(this.key);
    this.key = "";
  },
});

/** Steers from START to the region of task 2; gives back how many plans were seen on the way. */
async function driveToRegion(page, hands) {
  const way = [[2.05, -0.3], [2.5, 1.25], [4.0, 2.5]];
  const inside = (p) => p.x > 3 && p.x < 5 && p.y > 1.5 && p.y < 3.5;
  const plans = new Set(), begun = Date.now(), drawn = await page.evaluate(() => window.tandem.view.drawn);
  await hands.hold();
  for (const end = Date.now() + 2 * LONG; ; ) {
    const [p, plan, reason] = await page.evaluate(() => {
      const { robot } = window.tandem;
      return [robot.pose, robot.get("plan")?.at(-1), robot.get("arbitration/status")?.reason_code.value];
    });
    if (inside(p)) break;
    if (reason === ReasonCode.STICK_MOVED) { // the machine stood for a while: what a person does then
      await hands.letGo();
      await pause(200);
      await hands.hold();
    }
    assert.ok(Date.now() < end, `stuck at ${p.x}, ${p.y}`);
    while (way.length > 1 && distance(p, { x: way[0][0], y: way[0][1] }) < 0.7) way.shift();
    const bearing = Math.atan2(way[0][1] - p.y, way[0][0] - p.x) - p.heading;
    await hands.steer(Math.atan2(Math.sin(bearing), Math.cos(bearing)));
    plans.add(JSON.stringify(plan));
    if (plans.size === 50) await picture(page, "user_test");
    await pause(50);
  }
  const rate = ((await page.evaluate(() => window.tandem.view.drawn)) - drawn) / ((Date.now() - begun) / 1000);
  console.log(`${rate.toFixed(0)} pictures a second`);
  assert.ok(rate > 4, "the picture stutters"); // 20 and more where nothing else runs
  const released = Date.now();
  await hands.letGo();
  await stands(page);
  console.log(`stands ${Date.now() - released} ms after letting go`);
  return plans.size;
}

// --- the robot in a namespace ------------------------------------------------------------------
const banner = (page, text) => until(page, (t) => document.getElementById("banner").textContent.startsWith(t), text);

// After first use the tab keeps the token: it is not in the address, and it survives a reload.
async function keepsTheToken(page) {
  assert.ok(!page.url().includes(TOKEN) && page.url().includes("user_test"), page.url());
  await page.reload();
  await until(page, () => window.tandem.robot.pose && window.tandem.robot.speed);
  const stranger = await (await browser.newContext()).newPage();
  await stranger.goto(page.url());
  await until(stranger, () => document.getElementById("connection").textContent === "connection lost");
  assert.ok(!(await stranger.evaluate(() => window.tandem.robot.pose)), "connected without the token");
  await stranger.context().close();
}

async function userTest(page) {
  const begin = (hands) => {
    const button = page.getByRole("button", { name: "Begin" });
    return "key" in hands ? button.press("Enter", { timeout: LONG }) : button.click({ timeout: LONG });
  };
  assert.ok(distance(await pose(page), { x: START[0], y: START[1] }) < 0.01, "the page shows another robot");
  for (const service of ["arbitration/set_policy", "local_planner/set_parameters", "diff_drive_sim/reset"])
    await until(page, (name) => window.tandem.connection.has(name), `/robot1/${service}`);
  await page.locator("#user-test > summary").click();
  await page.locator("#person").fill("1");
  await page.getByRole("button", { name: "Start the test" }).click();
  for (const hands of [stickOf(page), keysOf(page)]) {
    await begin(hands); // practice
    await begin(hands); // task 1
    await begin(hands); // task 2
    await banner(page, "Task 2");
    const plans = await driveToRegion(page, hands);
    if ("key" in hands) assert.ok(plans > 20, "the plan does not move");
  }
  await page.locator("#results").waitFor({ timeout: LONG });
  await until(page, () => document.getElementById("toast").textContent.startsWith("user test saved"));
  await picture(page, "results");
  checkResults(await page.locator("#results tr").allInnerTexts());
}

// The table on the page, and the files on the robot.
function checkResults(rows) {
  console.log(rows.join("\n"));
  assert.equal(rows.length, 5);
  assert.match(rows[1], /You, direct\s+\d+ in 1 s\s+\d+\.\d s/);
  assert.match(rows[2], /You, shared\s+0 in 1 s\s+\d+\.\d s/);
  const [heading, ...saved] = readFileSync(`${results}/user_tests.csv`, "utf8").trim().split("\n");
  assert.equal(saved.length, 6);
  assert.match(saved[5], /^1,shared,2,0,120\.0,[\d.]+,1,0,/);
  const { person, trials } = JSON.parse(readFileSync(`${results}/user_test_1.json`, "utf8"));
  assert.equal(person, 1);
  const names = heading.split(",").slice(1);
  const number = (text) => (text === "manual" || text === "shared" ? text : Number(text));
  for (const [i, trial] of trials.entries())
    assert.deepEqual(saved[i].split(",").slice(1).map(number), names.map((name) => number(trial[name])));
  assert.deepEqual(trials.map((t) => `${t.method} ${t.task} ${t.practice}`), [
    "manual 1 true", "manual 1 false", "manual 2 false", "shared 1 true", "shared 1 false", "shared 2 false",
  ]);
  assert.match(rows[2], new RegExp(`${trials[5].time.toFixed(1)} s`));
  console.log(`${trials[5].path_length} m, clearance ${trials[5].min_clearance} m`);
  assert.ok(trials[5].path_length > 3 && trials[5].min_clearance < 1); // between poles
}

// --- the other robot ---------------------------------------------------------------------------
async function backToTheStart() {
  await page.locator("#reset").click();
  await until(page, () => window.tandem.robot.pose.x < -3.9);
}

// Positions of the robot and of the point one metre ahead of it in the picture [px].
const seen = () =>
  page.evaluate(() => {
    const { view, robot } = window.tandem, { x, y, heading } = robot.pose;
    const box = document.getElementById("view").getBoundingClientRect();
    const ahead = view.place(x + Math.cos(heading), y + Math.sin(heading));
    return { robot: view.place(x, y), ahead, middle: { x: box.width / 2, y: box.height / 2 }, heading };
  });

function checkView(mode, { robot, ahead, middle, heading }) {
  const up = Math.atan2(robot.y - ahead.y, ahead.x - robot.x); // of what is ahead, on the picture
  assert.ok(Math.abs(up - (mode === "map" ? heading : Math.PI / 2)) < 0.05, `${mode}: ahead is at ${up}`);
  if (mode !== "map") assert.ok(distance(robot, middle) < 10, `${mode}: the robot is not in the middle`);
}

async function driveInEachView() {
  for (const [view, key] of [["Follow", "ArrowUp"], ["Leader", "u"], ["Map", "u"]]) {
    await page.getByText(view, { exact: true }).click(); // which does not take the arrows
    assert.ok(await page.locator(`input[name=frame][value=${view.toLowerCase()}]`).isChecked(), `${view} was not chosen`);
    await page.keyboard.down(key);
    await moves(page);
    if (view === "Leader")
      await until(page, () => /^Leader 0\.[1-9]\d m ahead, \d\.\d\d m to the left/.test(document.getElementById("leader").textContent));
    await picture(page, `view_${view.toLowerCase()}`);
    await page.keyboard.up(key);
    await stands(page);
    checkView(view.toLowerCase(), await seen());
  }
}

async function driveToAGoal() {
  await backToTheStart();
  const choose = async (group, name) => page.locator(group).getByText(name, { exact: true }).click();
  await choose("#methods", "goal");
  await until(page, () => document.getElementById("view").classList.contains("points")); // or the click is none
  await choose("#modes", "Adaptive");
  await until(page, () => window.tandem.robot.get("arbitration/status")?.policy === "adaptive");
  const at = await page.evaluate(() => window.tandem.view.place(-3, -3.6));
  await page.locator("#view").click({ position: { x: at.x, y: at.y } });
  await choose("#modes", "Auto");
  await until(page, () => Math.hypot(window.tandem.robot.pose.x + 3, window.tandem.robot.pose.y + 3.6) < 0.3);
  await page.locator("#goal input").first().focus();
  for (const value of ["-2.2", "-3.6", "0"]) {
    await page.keyboard.press("ControlOrMeta+A");
    await page.keyboard.type(value);
    await page.keyboard.press("Tab");
  }
  await until(page, () => window.tandem.view.draft?.x === -2.2 && window.tandem.view.draft.heading === 0);
  await picture(page, "goal");
  await page.keyboard.press("Enter"); // on the button, where Tab has led
  await until(page, () => Math.hypot(window.tandem.robot.pose.x + 2.2, window.tandem.robot.pose.y + 3.6) < 0.3);
  await choose("#modes", "Shared");
  await choose("#methods", "leader");
  await until(page, () => window.tandem.robot.get("planner/status")?.method === "leader");
  await stands(page);
}

async function driveAndDisturb() {
  await step("the keyboard drives in each view, and a key let go stops", driveInEachView);

  await step("a page that loses the focus releases the stick", async () => {
    await page.keyboard.down("i");
    await moves(page);
    await page.evaluate(() => window.dispatchEvent(new Event("blur")));
    await stands(page);
    await page.keyboard.up("i");
  });

  await step("a press whose first sample is lost still drives", async () => {
    await page.evaluate(() => {
      const { connection } = window.tandem, publish = connection.publishFresh.bind(connection);
      connection.publishFresh = () => ((connection.publishFresh = publish), true);
    });
    await page.keyboard.down("i");
    await moves(page);
    await page.keyboard.up("i");
    await stands(page);
  });

  await step("a gamepad drives while its button is held", async () => {
    await page.evaluate(() => {
      window.pad = { connected: true, id: "pad", axes: [0, -0.6], buttons: [{ pressed: true }] };
      navigator.getGamepads = () => [window.pad];
    });
    // It may be unused, or may not have reported its stick yet.
    await gives(page, ReasonCode.STICK_MOVED);
    await until(page, () => document.getElementById("notice").textContent.startsWith("The stick is not at rest"));
    assert.ok((await speed(page)) < STANDS);
    await page.evaluate(() => (window.pad.axes = [0.02, -0.03]));
    await until(page, (c) => window.tandem.robot.get("arbitration/status")?.reason_code.value !== c, ReasonCode.STICK_MOVED);
    await page.evaluate(() => (window.pad.axes = [0, -0.6]));
    await moves(page);
    await page.evaluate(() => (window.pad.buttons[0].pressed = false));
    await stands(page);
  });

  await step("the emergency stop stops a robot that is driven, until it is released", async () => {
    await page.keyboard.down("i");
    await moves(page);
    await page.keyboard.press("Escape");
    await stands(page);
    await page.keyboard.up("i");
    await page.keyboard.down("i");
    await until(page, () => window.tandem.robot.get("arbitration/status")?.emergency_stop);
    await until(page, () => document.getElementById("notice").textContent.startsWith("Emergency stop"));
    await until(page, () => document.getElementById("remedy").textContent.startsWith("let every sender of e_stop"));
    await picture(page, "emergency_stop");
    assert.ok((await speed(page)) < STANDS);
    await page.locator("#release").click(); // with the key still held: that starts nothing
    await gives(page, ReasonCode.LET_GO_FIRST);
    assert.ok((await speed(page)) < STANDS);
    await page.keyboard.up("i");
    await gives(page, ReasonCode.USER_SILENT);
    await page.keyboard.down("i");
    await moves(page);
    await page.keyboard.up("i");
    await stands(page);
  });

  await step("no key sticks, and only the first mouse button drives", async () => {
    await page.keyboard.down("Comma");
    await moves(page);
    await page.keyboard.down("Shift");
    await page.keyboard.up("Comma"); // says "<"
    await page.keyboard.up("Shift");
    await stands(page);
    await stick(page, 0, 0);
    await page.mouse.down({ button: "right" });
    await stick(page, 1, 0);
    assert.equal(await page.evaluate(() => window.tandem.driver.stick), undefined);
    await page.mouse.up({ button: "right" });
  });

  await step("a page that only watches is notified, and can take the wheel", async () => {
    await page.keyboard.down("i");
    await moves(page);
    await until(watcher, () => window.tandem.robot.seat.driver === "other");
    await picture(watcher, "phone_other_drives");
    await watcher.locator("#take").click();
    await until(page, () => window.tandem.robot.seat.driver === "other");
    await stands(page);
    await page.keyboard.up("i");
    await page.locator("#take").click();
    await until(page, () => window.tandem.robot.seat.driver === "you");
  });

  await step("the planner drives to a goal set on the map, and to one that is typed", driveToAGoal);

  await step("losing the network stops the robot; nothing arrives late, and it does not restart", async () => {
    await backToTheStart();
    await page.keyboard.down("i");
    await moves(watcher);
    cut();
    const lost = Date.now();
    await stands(watcher);
    console.log(`stands ${Date.now() - lost} ms after the network was cut`);
    await until(page, () => document.body.classList.contains("lost"));
    await picture(page, "lost");
    const place = await pose(watcher);
    mend(); // what waited in the wires arrives now
    await until(page, () => !document.body.classList.contains("lost") && window.tandem.robot.speed);
    await pause(500);
    assert.ok(distance(place, await pose(watcher)) < 0.02, "a stick from the past drives the robot");
    await page.keyboard.up("i");
    await until(page, () => !window.tandem.driver.dropped); // the page has seen it
  });

  await step("an autonomous robot stops when the page that started it disconnects", async () => {
    const third = await open(address, LAPTOP);
    const choose = async (group, name) => third.locator(group).getByText(name, { exact: true }).click();
    await until(third, () => window.tandem.robot.seat.driver === "nobody");
    await choose("#methods", "goal");
    await until(third, () => !document.getElementById("goal").hidden);
    const at = await third.evaluate(() => window.tandem.view.place(-4, 4));
    await third.locator("#view").click({ position: { x: at.x, y: at.y } });
    await choose("#modes", "Auto");
    await moves(watcher);
    await until(watcher, () => window.tandem.robot.seat.driver === "nobody"); // who set the goal is silent since
    await until(watcher, () => document.getElementById("seat").textContent === "Drives by itself");
    await third.close();
    await until(watcher, () => window.tandem.robot.get("arbitration/status")?.policy === "shared");
    await stands(watcher);
    await watcher.locator("#methods").getByText("leader", { exact: true }).click();
    await until(watcher, () => window.tandem.robot.get("planner/status")?.method === "leader");
  });

  await step("closing the page stops the robot", async () => {
    await page.keyboard.down("i");
    await moves(watcher);
    await page.close();
    await stands(watcher);
  });

  await step("a parameter's slider sets it", async () => {
    await until(watcher, () => window.tandem.robot.seat.driver === "nobody");
    await watcher.locator("#tuning > summary").click();
    await watcher.locator("#node").selectOption("/teleop");
    const leash = watcher.locator(".parameter", { hasText: "leash" }).locator("input[type=number]");
    await leash.fill("1.5");
    await leash.press("Enter");
    await until(watcher, () => document.getElementById("toast").textContent === "leash is 1.5");
    await picture(watcher, "phone_parameters");
  });
}

await Promise.all([
  step("the token leaves the address and is kept", () => keepsTheToken(testPage)).then(() =>
    step("a user test to its table: direct by the stick on the screen, shared by the keyboard", () => userTest(testPage))),
  driveAndDisturb(),
]);
await browser.close();
for (const robot of robots) robot.kill("SIGTERM");
process.exit(0);
