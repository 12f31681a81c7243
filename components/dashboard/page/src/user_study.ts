// SPDX-License-Identifier: Apache-2.0
// Devalla's user test (2020, §4.2 and table C.2) in the browser: for each method a time to practise,
// task 1 (two minutes at will: collisions), task 2 (to the marked region: time).
import type { Connection } from "./connection";
import type { Driver } from "./driver";
import { setText } from "./parameters";
import type { View } from "./view";

interface Phase {
  method: "manual" | "shared";
  task: 0 | 1 | 2; // 0: practice
  allowed: number; // [s]
}
/** As the robot's side measures and saves it: see user_study.hpp. */
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
  private running?: { id: number; phase: Phase; later: Phase[] };
  private person = 1;
  private practice = 60; // [s]
  private task1 = 120; // [s]
  private countdown = 3; // [s]

  constructor(
    private connection: Connection,
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

  // The robot's side measures, by the code that measures everything here.
  private run(phase: Phase, later: Phase[]): void {
    this.driver.enabled = true;
    const id = Date.now();
    const sent = this.connection.publish(`${this.names().dashboard}/begin_trial`, "tandem.TrialRequest", {
      id, method: phase.method, task: Math.max(1, phase.task), practice: phase.task === 0, allowed: phase.allowed,
      ...(phase.task === 2 ? { region: [REGION.x0, REGION.y0, REGION.x1, REGION.y1] } : {}),
    });
    if (sent) {
      this.running = { id, phase, later };
      this.say(TASK[phase.task]!); // until the robot answers
      return;
    }
    this.say("The connection is lost");
    this.next([phase, ...later]);
  }

  /** What the robot's side says of the trial that goes on there. */
  onTrial(state: { id: number; time: number; collisions: number; trial?: Trial }): void {
    if (state.id !== this.running?.id) return;
    const { phase, later } = this.running;
    const clock = phase.task === 2 ? state.time : phase.allowed - state.time;
    this.say(
      `${TASK[phase.task]}: ${clock.toFixed(1)} s` + (state.collisions > 0 ? `, ${state.collisions} collisions` : ""),
    );
    if (!state.trial) return;
    this.end();
    this.trials.push(state.trial);
    this.next(later);
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
    this.running = undefined;
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
