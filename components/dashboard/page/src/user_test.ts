// SPDX-License-Identifier: Apache-2.0
// Devalla's user test (2020, §4.2 and table C.2) in the browser: for each method a time to practise,
// task 1 (two minutes at will: collisions), task 2 (to the marked region: time).
import type { Connection } from "./connection";
import type { Driver } from "./driver";
import { setText } from "./parameters";
import type { Pose, Robot } from "./robot";
import type { View } from "./view";

interface Phase {
  method: "manual" | "shared";
  task: 0 | 1 | 2; // 0: practice
  allowed: number; // [s]
}
/** As the robot's side saves it: see user_test.hpp. */
interface Trial {
  method: string;
  task: number;
  practice: boolean;
  allowed: number;
  time: number;
  reached: boolean;
  collisions: number;
  min_clearance: number;
  path_length: number;
}

const REGION = { x0: 3, y0: 1.5, x1: 5, y1: 3.5 }; // [m] of task 2
const BEAT = 50; // [ms]
const TITLE = { manual: "Direct", shared: "Shared" };
const TASK = ["Practice", "Task 1", "Task 2"];
const WHAT = [
  "Get used to it. Drive wherever you like.",
  "Drive wherever you like, and touch nothing.",
  "Drive to the marked region as fast as you can without touching anything.",
];
// Table C.2: seven people; "shared" is after training for the time.
const THESIS: [string, string, string][] = [
  ["Thesis, direct", "4.1 (29 of 7 people)", "18.2 s"],
  ["Thesis, shared", "0", "18.1 s (untrained 19.4 s)"],
];

/** Direct first for odd numbers, shared first for even ones: balanced over people. */
export function phases(person: number, practice: number, task1: number): Phase[] {
  const methods: Phase["method"][] = person % 2 === 1 ? ["manual", "shared"] : ["shared", "manual"];
  return methods.flatMap((method): Phase[] => [
    { method, task: 0, allowed: practice },
    { method, task: 1, allowed: task1 },
    { method, task: 2, allowed: 120 },
  ]);
}

export class UserTest {
  private trials: Trial[] = [];
  private timer = 0;
  private person = 1;
  private practice = 60; // [s]
  private task1 = 120; // [s]
  private countdown = 3; // [s]

  constructor(
    private connection: Connection,
    private robot: Robot,
    private driver: Driver,
    private view: View,
    private names: () => { namespace: string; dashboard: string },
    private panel: HTMLElement,
    private banner: HTMLElement,
  ) {
    // ?user_test=5,10,1: other lengths of practice, task 1 and countdown [s], for trying it out.
    const lengths = new URLSearchParams(location.search).get("user_test")?.split(",").map(Number);
    if (lengths?.length === 3 && lengths.every((s) => s >= 0 && s <= 3600))
      [this.practice, this.task1, this.countdown] = lengths as [number, number, number];
    this.intro();
  }

  private intro(): void {
    this.end();
    const number = document.createElement("input");
    number.type = "number";
    number.min = "1";
    number.id = "person";
    number.value = localStorage.getItem("person") ?? "1";
    const label = document.createElement("label");
    label.className = "pick";
    label.append("Person number ", number);
    this.show(
      `Two tasks with direct and with shared control, ${this.practice} s of practice each. No name, no ` +
        "personal data: your number decides which comes first. The results are saved on the robot.",
      label,
      this.button("Start the test", () => {
        this.person = Math.max(1, Math.round(Number(number.value)) || 1);
        this.trials = [];
        this.next(phases(this.person, this.practice, this.task1));
      }),
    );
  }

  private next(rest: Phase[]): void {
    const [phase, ...later] = rest;
    if (!phase) return this.finish();
    const limit = phase.task === 2 ? "" : ` ${phase.allowed} s.`;
    this.show(
      `${TITLE[phase.method]} control, ${TASK[phase.task]}. ${WHAT[phase.task]}${limit}`,
      this.button("Begin", () => void this.prepare(phase, later)),
      this.button("Leave the test", () => this.intro()),
    );
    this.panel.scrollIntoView({ block: "nearest" });
  }

  private async prepare(phase: Phase, later: Phase[]): Promise<void> {
    this.show("…");
    window.scrollTo(0, 0); // on a phone, to the stick
    const { namespace } = this.names();
    this.driver.enabled = false;
    try {
      const policy = { policy: phase.method };
      await this.connection.call(`${namespace}/arbitration/set_policy`, policy);
      const planner = `${namespace}/local_planner`;
      if (this.connection.has(`${planner}/set_parameters`))
        await setText(this.connection, planner, "method", "leader"); // as in the thesis
      await this.connection.call(`${namespace}/diff_drive_sim/reset`, {});
    } catch (error) {
      this.driver.enabled = true;
      this.say((error as Error).message);
      return this.next([phase, ...later]);
    }
    this.view.region = phase.task === 2 ? REGION : undefined;
    let left = this.countdown;
    const count = () => {
      if (left === 0) return this.run(phase, later);
      this.say(String(left--));
      this.timer = window.setTimeout(count, 1000);
    };
    count();
    this.show(WHAT[phase.task]!, this.button("Leave the test", () => this.intro()));
  }

  private run(phase: Phase, later: Phase[]): void {
    this.driver.enabled = true;
    const start = performance.now(), before = this.robot.collisions;
    let last: Pose | undefined;
    const trial: Trial = {
      method: phase.method, task: Math.max(1, phase.task), practice: phase.task === 0, allowed: phase.allowed,
      time: 0, reached: false, collisions: 0, min_clearance: 1e3, path_length: 0,
    };
    this.timer = window.setInterval(() => {
      trial.time = Math.min(phase.allowed, (performance.now() - start) / 1000);
      trial.collisions = Math.max(0, this.robot.collisions - before);
      const clearance = this.robot.get("safety_filter/status")?.clearance;
      if (clearance >= 0) trial.min_clearance = Math.min(trial.min_clearance, clearance);
      const pose = this.robot.pose;
      if (pose && last) trial.path_length += Math.hypot(pose.x - last.x, pose.y - last.y);
      last = pose;
      trial.reached = phase.task === 2 && pose !== undefined && inside(pose);
      const clock = phase.task === 2 ? trial.time : phase.allowed - trial.time;
      this.say(`${TASK[phase.task]}: ${clock.toFixed(1)} s` + (trial.collisions > 0 ? `, ${trial.collisions} collisions` : ""));
      if (!trial.reached && trial.time < phase.allowed) return;
      this.end();
      this.trials.push(trial);
      this.next(later);
    }, BEAT);
  }

  private finish(): void {
    const { dashboard } = this.names();
    const sent = this.connection.publish(`${dashboard}/user_test`, "tandem.UserTest", {
      person: this.person,
      trials: this.trials,
    });
    if (sent) localStorage.setItem("person", String(this.person + 1));
    const rows = (["manual", "shared"] as const).map((method): [string, string, string] => {
      const of = (task: number) => this.trials.find((t) => t.method === method && t.task === task && !t.practice)!;
      const first = of(1), second = of(2);
      const shortened = first.allowed === 120 ? "" : ` in ${first.allowed} s`;
      return [
        `You, ${TITLE[method].toLowerCase()}`,
        `${first.collisions}${shortened}`,
        second.reached ? `${second.time.toFixed(1)} s` : "not reached",
      ];
    });
    this.show(
      sent ? "Thank you. Collisions in task 1, time of task 2:" : "The connection is lost, and nothing is saved yet. Collisions in task 1, time of task 2:",
      table([...rows, ...THESIS]),
      sent ? this.button("Next person", () => this.intro()) : this.button("Save again", () => this.finish()),
    );
    this.panel.scrollIntoView({ block: "nearest" });
  }

  private end(): void {
    clearTimeout(this.timer);
    clearInterval(this.timer);
    this.driver.enabled = true;
    this.view.region = undefined;
    this.say("");
  }

  private say(text: string): void {
    this.banner.textContent = text;
    this.banner.hidden = text === "";
    this.view.change();
  }

  private show(text: string, ...parts: HTMLElement[]): void {
    const paragraph = document.createElement("p");
    paragraph.textContent = text;
    this.panel.replaceChildren(paragraph, ...parts);
  }

  private button(text: string, act: () => void): HTMLButtonElement {
    const button = document.createElement("button");
    button.textContent = text;
    button.onclick = () => {
      button.blur(); // the space bar is the emergency stop
      act();
    };
    return button;
  }
}

function inside(pose: Pose): boolean {
  return pose.x > REGION.x0 && pose.x < REGION.x1 && pose.y > REGION.y0 && pose.y < REGION.y1;
}

function table(rows: [string, string, string][]): HTMLTableElement {
  const result = document.createElement("table");
  result.id = "results";
  const add = (cells: string[], kind: "th" | "td") => {
    const row = result.insertRow();
    cells.forEach((text, i) => {
      const cell = document.createElement(i === 0 ? "th" : kind);
      cell.textContent = text;
      row.append(cell);
    });
  };
  add(["", "Collisions", "Time"], "th");
  for (const row of rows) add(row, "td");
  return result;
}
