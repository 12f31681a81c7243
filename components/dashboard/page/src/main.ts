// SPDX-License-Identifier: Apache-2.0
import { Connection, type Message } from "./connection";
import { belongsToControl, Driver, gamepad, Keyboard, screenStick, showStick, USUAL } from "./driver";
import { Goal } from "./goal";
import { choicesOf, nodesWithParameters, setText, showParameters } from "./parameters";
import { ReasonCode } from "./reason_code";
import { polygons, rectangle, Robot } from "./robot";
import { takeToken } from "./token";
import { UserTest } from "./user_study";
import { drawPlot, View, type ViewMode } from "./view";

const SEAT = "tandem.Seat";
const SLOW = 200; // [ms] between two writings of the numbers

const at = <T extends HTMLElement = HTMLElement>(id: string) => document.getElementById(id) as T;

function serverUrl(): string {
  const token = takeToken();
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${location.host}/${token ? `?token=${encodeURIComponent(token)}` : ""}`;
}

const connection = new Connection(serverUrl());
const robot = new Robot(connection);
const view = new View(at<HTMLCanvasElement>("view"), robot);
const keyboard = new Keyboard();
const driver = new Driver(connection, () => `${namespace}/joy`, [
  screenStick(at("stick"), at("knob")),
  keyboard.source,
  gamepad((name) => say(name ? `Gamepad: ${name}` : "The gamepad is gone")),
]);
const goal = new Goal(connection, robot, view, at<HTMLFormElement>("goal"), () => namespace);
let namespace = "";
let dashboard = "/dashboard"; // the node that serves this page
let following = false;
(window as any).tandem = { connection, robot, driver, view }; // for the browser's console

// --- words to the person -----------------------------------------------------------------------
let sayTimer = 0;
function say(text: string): void {
  at("toast").textContent = text;
  at("toast").classList.add("shown");
  clearTimeout(sayTimer);
  sayTimer = window.setTimeout(() => at("toast").classList.remove("shown"), 4000);
}

function ask(service: string, request: Message = {}, node = namespace): Promise<Message> {
  return connection.call(`${node}/${service}`, request).catch((error: Error) => {
    say(error.message);
    throw error;
  });
}

// --- the robot behind the connection -----------------------------------------------------------
// The seat's channel tells the namespace that the robot's topics live in: /a/dashboard/seat.
function findRobot(): void {
  const seat = connection.topicOf(SEAT);
  if (seat === undefined || following) return;
  following = true;
  dashboard = seat.slice(0, -"/seat".length);
  namespace = dashboard.slice(0, dashboard.lastIndexOf("/"));
  connection.subscribe(seat, (m) => {
    if (m.driver === "other") driver.drop(); // holding on does not win back a lost wheel
    robot.seat = m;
    showSeat();
  });
  connection.subscribe(`${dashboard}/trial`, (m) => userTest.onTrial(m));
  robot.follow(namespace);
}

async function readOutline(): Promise<void> {
  const names = ["length", "width", "center_x", "footprint", "footprint_parts"];
  const { values } = await connection.call(`${namespace}/safety_filter/get_parameters`, { names });
  const [length, width, centre, footprint, counts] = values;
  robot.outline = [...footprint.double_array_value].length
    ? polygons([...footprint.double_array_value], [...counts.double_array_value])
    : [rectangle(length.double_value, width.double_value, centre.double_value)];
  view.change();
}

// Where teleop tells which axes and buttons it reads; else it is spoken to as ours is by default.
async function readLayout(): Promise<void> {
  const names = [
    "axis_linear", "axis_angular", "deadman_button", "scale_linear", "scale_angular", "end_button", "axis_range",
  ];
  driver.layout = undefined;
  const { values } = await connection.call(`${namespace}/teleop/get_parameters`, { names });
  const index = (i: number) => Number(values[i].integer_value);
  driver.layout = {
    axisLinear: index(0),
    axisAngular: index(1),
    deadmanButton: index(2),
    scaleLinear: values[3].double_value,
    scaleAngular: values[4].double_value,
    endButton: values[5].type ? index(5) : USUAL.endButton,
    axisRange: values[6].double_value || USUAL.axisRange,
  };
}

// The planner's methods, where it lets them be changed.
async function readMethods(): Promise<void> {
  const node = `${namespace}/local_planner`;
  const { descriptors } = await connection.call(`${node}/describe_parameters`, { names: ["method"] });
  at("methods").append(...choicesOf(descriptors[0]).map(methodButton));
  at("methods").hidden = descriptors[0].read_only;
}

function methodButton(name: string): HTMLElement {
  const label = document.createElement("label"), button = document.createElement("input");
  const words = document.createElement("span");
  words.textContent = name;
  Object.assign(button, { type: "radio", name: "method", value: name });
  button.onchange = () =>
    setText(connection, `${namespace}/local_planner`, "method", name)
      .then(() => say(`The planner's method is ${name}`))
      .catch((error: Error) => say(error.message));
  label.append(button, words);
  return label;
}

let layoutKnown = false;
let methodsKnown = false;
let outlineKnown = false;
connection.onServices = () => {
  findRobot();
  at("user-test").hidden = !connection.has(`${namespace}/diff_drive_sim/reset`);
  at("reset").hidden = !connection.has(`${namespace}/diff_drive_sim/reset`);
  if (!outlineKnown && connection.has(`${namespace}/safety_filter/get_parameters`)) {
    outlineKnown = true;
    readOutline().catch(() => (outlineKnown = false));
  }
  if (!layoutKnown && connection.has(`${namespace}/teleop/get_parameters`)) {
    layoutKnown = true;
    readLayout().catch(() => {
      driver.layout = USUAL;
      layoutKnown = false;
    });
  }
  if (!methodsKnown && connection.has(`${namespace}/local_planner/describe_parameters`)) {
    methodsKnown = true;
    readMethods().catch(() => (methodsKnown = false));
  }
  const nodes = nodesWithParameters(connection);
  const select = at<HTMLSelectElement>("node");
  if (nodes.join() === [...select.options].map((o) => o.value).join()) return;
  const chosen = select.value;
  select.replaceChildren(...nodes.map((node) => new Option(node.slice(1), node)));
  select.value = nodes.includes(chosen) ? chosen : (nodes.find((n) => n === `${namespace}/local_planner`) ?? nodes[0] ?? "");
};
connection.onState = (connected) => {
  document.body.classList.toggle("lost", !connected);
  if (!connected) driver.drop(); // the robot does not start off by itself when the network is back
  at("connection").textContent = connected ? "connected" : "connection lost";
  robot.seat = { driver: "nobody", clients: 1 };
  showSeat();
};
connection.onStatus = say;
robot.onChange = () => {
  view.change();
  if (reasonCode() === ReasonCode.STICK_MOVED) driver.beginAgain();
};
driver.onChange = () => 
  showStick(at("stick"), at("knob"), driver.stick, robot.get("joy/set_feedback", 250));

// --- who drives ----------------------------------------------------------------------------------
function showSeat(): void {
  const { driver: who, clients } = robot.seat;
  document.body.classList.toggle("other-drives", who === "other");
  write("seat", { you: "You drive", other: "Someone else drives", nobody: besidesPages() }[who]);
  at("clients").textContent = clients === 1 ? "" : `${clients} connected`;
}

// The seat is the pages'; the robot may be driven from a terminal, by a joystick of its own, by itself.
function besidesPages(): string {
  const arbitration = robot.get("arbitration/status");
  if (!connection.connected || !arbitration) return "The robot is silent";
  if (arbitration.source === "none") return "Nobody drives";
  return arbitration.policy === "autonomous" && arbitration.source !== "user" ? "Drives by itself" : "Driven from elsewhere";
}

at("take").onclick = () => ask("take_wheel", {}, dashboard).then((m) => say(m.message));

// --- numbers ---------------------------------------------------------------------------------------
function percent(value: number): string {
  return `${Math.round(100 * value)} %`;
}

function write(id: string, text: string): void {
  const element = at(id);
  if (element.textContent !== text) element.textContent = text;
}

function showNumbers(): void {
  const arbitration = robot.get("arbitration/status");
  const planner = robot.get("planner/status");
  const filter = robot.get("safety_filter/status");
  const speed = robot.speed;
  write("speed", speed ? `${(Math.round(100 * speed.v) / 100 || 0).toFixed(2)} m/s` : "–");
  write("turn", speed ? `${Math.round((speed.w * 180) / Math.PI) || 0} °/s` : "–"); // and no -0
  const clearance = [filter, planner].map((status) => status?.clearance).find(Number.isFinite);
  write("clearance", Number.isFinite(clearance) ? `${clearance.toFixed(2)} m` : "–");
  at("clearance").classList.toggle("near", clearance < 0.15);
  write("policy", arbitration?.policy ?? "–");
  write("source", SOURCES[arbitration?.source] ?? arbitration?.source ?? "–");
  write("reason", arbitration ? (REASONS[arbitration.reason_code.value] ?? arbitration.reason) : "arbitration is silent");
  write("remedy", arbitration?.remedy || "–");
  write("alpha", arbitration ? percent(arbitration.alpha) : "–");
  write("filter", filter ? `${filter.reason}${filter.scale < 0.995 ? ` (${percent(filter.scale)} passes)` : ""}` : "–");
  write("planner", planner ? `${planner.method}: ${planner.status_text}` : "the planner is silent");
  write("solve", planner ? `${(1000 * planner.solve_time).toFixed(1)} ms` : "–");
  write("missed", planner ? String(planner.overruns) : "–");
  write("collisions", String(robot.collisions));
  showSeat();
  at("leader").hidden = view.mode !== "leader";
  write("leader", robot.leader());
  at("collisions").classList.toggle("near", robot.inContact);
  const stopped = arbitration?.emergency_stop ?? false;
  document.body.classList.toggle("stopped", stopped);
  showNotice(stopped);
  at("release").hidden = !stopped;
  for (const button of document.querySelectorAll<HTMLInputElement>("input[name=mode]"))
    button.checked = button.value === arbitration?.policy;
  for (const button of document.querySelectorAll<HTMLInputElement>("input[name=method]"))
    button.checked = button.value === planner?.method;
  if (planner) goal.show(planner.method === "goal");
  drawPlot(at<HTMLCanvasElement>("plot"), robot);
}
// Why the stick in one's hand moves nothing.
function showNotice(stopped: boolean): void {
  let text = "";
  if (!connection.connected) text = "No connection. The robot stops by itself.";
  else if (stopped) text = "Emergency stop. The robot stands until the stop is released.";
  else if (driver.stick && reasonCode() === ReasonCode.STICK_MOVED) text = "The stick is not at rest. Let go of it, then drive.";
  write("notice", text);
  at("notice").hidden = text === "";
}
const SOURCES: Record<string, string> = {
  none: "nobody", user: "the person", shared: "the planner, for the person",
  blend: "person and planner", nav: "autonomy",
};
const REASONS: Record<number, string> = {
  [ReasonCode.USER_SILENT]: "nobody holds a stick", [ReasonCode.SHARED_SILENT]: "the planner is silent",
  [ReasonCode.FOLLOWS_SOURCE]: "the command is passed on", [ReasonCode.NO_COMMAND]: "nobody steers",
};
function reasonCode(): ReasonCode | undefined {
  return robot.get("arbitration/status")?.reason_code.value;
}
setInterval(showNumbers, SLOW);

// --- buttons ---------------------------------------------------------------------------------------
function emergencyStop(): void {
  const sent = connection.publish(`${namespace}/e_stop`, "std_msgs/msg/Bool", { data: true });
  say(sent ? "Emergency stop" : "No connection: the stop was not sent");
}
at("stop").onclick = emergencyStop;
window.addEventListener("keydown", (event) => {
  if (event.key === "Escape" || (event.key === " " && !belongsToControl(event))) {
    emergencyStop();
    event.preventDefault();
  }
});

// What is clicked does not take the keys, not for a moment: the arrows drive, and the space bar stops.
let pointing = false;
window.addEventListener("pointerdown", () => (pointing = true), true);
for (const end of ["click", "pointercancel"]) window.addEventListener(end, () => setTimeout(() => (pointing = false)), true);
window.addEventListener("keydown", () => (pointing = false), true);
window.addEventListener("focusin", (event) => {
  const chosen = event.target;
  if (pointing && chosen instanceof HTMLElement && chosen.matches(KEY_TAKERS)) chosen.blur();
});
// The arrows end at the ends of a group: one to the left of Manual is not Auto.
window.addEventListener("keydown", (event) => {
  const at = event.target;
  if (!(at instanceof HTMLInputElement) || at.type !== "radio") return;
  const group = [...document.querySelectorAll<HTMLInputElement>(`input[name=${at.name}]`)];
  const end = { ArrowLeft: group[0], ArrowUp: group[0], ArrowRight: group.at(-1), ArrowDown: group.at(-1) }[event.key];
  if (at === end) event.preventDefault();
});

// What is chosen or shifted by pointing gives the keys back.
window.addEventListener("pointerup", () => {
  const chosen = document.activeElement;
  if (chosen instanceof HTMLInputElement && chosen.type === "range") chosen.blur();
});
let byKey = false;
window.addEventListener("keydown", () => (byKey = true), true);
window.addEventListener("pointerdown", () => (byKey = false), true);
window.addEventListener("change", (event) => {
  if (!byKey && event.target instanceof HTMLSelectElement) event.target.blur();
});
const KEY_TAKERS = "button, summary, input[type=radio], input[type=checkbox]";

at("release").onclick = async () => {
  connection.publish(`${namespace}/e_stop`, "std_msgs/msg/Bool", { data: false });
  for (let tries = 0; tries < 20; ++tries) {
    const answer = await ask("arbitration/release_emergency_stop").catch(() => undefined);
    if (!answer) return; // and why has been said
    say(answer.success ? "Released" : answer.message);
    if (answer.success) return;
  }
};
at("reset").onclick = () => ask("diff_drive_sim/reset").then(() => say("Back at the start"));

for (const button of document.querySelectorAll<HTMLInputElement>("input[name=mode]"))
  button.onchange = () =>
    ask("arbitration/set_policy", { policy: button.value }).then((m) => say(m.message));

for (const button of document.querySelectorAll<HTMLInputElement>("input[name=frame]"))
  button.onchange = () => {
    view.mode = button.value as ViewMode;
    view.change();
  };

keyboard.onScale = () =>
  say(`Keys: ${percent(keyboard.scale.linear)} forward, ${percent(keyboard.scale.angular)} turning`);

const userTest = new UserTest(
  connection, driver, view, () => ({ namespace, dashboard }), at("test"), at("banner"),
);

// --- parameters --------------------------------------------------------------------------------------
const loadParameters = () => {
  const node = at<HTMLSelectElement>("node").value;
  if (node)
    showParameters(connection, node, at("parameters"), say).catch((e: Error) => {
      at("parameters").textContent = e.message;
    });
};
at<HTMLSelectElement>("node").onchange = loadParameters;
at<HTMLDetailsElement>("tuning").ontoggle = () => {
  if (at<HTMLDetailsElement>("tuning").open) loadParameters();
};
