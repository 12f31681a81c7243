// SPDX-License-Identifier: Apache-2.0
// Where the robot is to go by itself: pointed out on the map, or typed, while the planner's method is goal.
import type { Connection } from "./connection";
import type { Pose, Robot } from "./robot";
import type { View } from "./view";

const DEGREES = 180 / Math.PI;

export class Goal {
  private shown?: Pose | "none"; // what the fields hold, but for what is typed

  constructor(
    private connection: Connection,
    private robot: Robot,
    private view: View,
    private form: HTMLFormElement,
    private namespace: () => string,
  ) {
    view.onPoint((pose) => this.form.hidden || this.send(pose));
    form.addEventListener("input", () => this.draft(this.typed()));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const pose = this.typed();
      if (pose) this.send(pose);
    });
  }

  /** Whether there is anything to choose a goal for; and the goal that holds, unless one is being typed. */
  show(wanted: boolean): void {
    if (wanted !== !this.form.hidden) {
      this.form.hidden = !wanted;
      this.view.pointable(wanted);
      this.draft(undefined);
      this.shown = undefined;
    }
    const goal = this.robot.goal ?? this.robot.pose;
    if (!wanted || !goal || this.view.draft || this.shown === (this.robot.goal ?? "none")) return;
    this.shown = this.robot.goal ?? "none";
    this.write(goal);
  }

  private send(goal: Pose): void {
    const header = { stamp: this.connection.stamp(), frame_id: this.robot.grid?.frame ?? "map" };
    const position = { x: goal.x, y: goal.y, z: 0 };
    const orientation = { x: 0, y: 0, z: Math.sin(goal.heading / 2), w: Math.cos(goal.heading / 2) };
    const message = { header, pose: { position, orientation } };
    const topic = `${this.namespace()}/goal_pose`;
    if (this.connection.publish(topic, "geometry_msgs/msg/PoseStamped", message)) this.draft(undefined);
  }

  private draft(pose?: Pose): void {
    this.view.draft = pose;
    this.view.change();
  }

  private typed(): Pose | undefined {
    const [x, y, degrees] = this.fields().map((field) => field.valueAsNumber) as [number, number, number];
    return Number.isFinite(x + y + degrees) ? { x, y, heading: degrees / DEGREES } : undefined;
  }

  private write({ x, y, heading }: Pose): void {
    const values = [x.toFixed(2), y.toFixed(2), String(Math.round(heading * DEGREES) || 0)];
    this.fields().forEach((field, i) => (field.value = values[i]!));
  }

  private fields(): HTMLInputElement[] {
    return [...this.form.querySelectorAll("input")];
  }
}
