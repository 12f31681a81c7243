// SPDX-License-Identifier: Apache-2.0
// What the page knows of the robot, kept up to date from its topics.
import type { Connection, Message } from "./connection";

export interface Pose {
  x: number;
  y: number;
  heading: number;
}
/** An ellipse of semi-axes a and b, or a rectangle of half sides a and b. */
export interface Obstacle {
  x: number;
  y: number;
  a: number;
  b: number;
  angle: number;
  isRectangle: boolean;
}
/** A place that the person may mean to go to, and how likely that is, in words. */
export interface Place {
  pose: Pose;
  belief: string;
}
/** A value and when it arrived [ms]; old ones are not shown. */
interface Timed<T> {
  value: T;
  at: number;
}
export interface Grid {
  width: number;
  height: number;
  resolution: number;
  origin: Pose;
  frame: string;
  picture: HTMLCanvasElement;
}
export interface Sample {
  at: number; // [ms]
  solve: number; // [ms]
  missed: boolean;
}

const FRESH = 500; // [ms]
const HISTORY = 20_000; // [ms] of planner times
const STEPS = 20; // of the ghost path
const GHOST = 1.5; // [s] that it looks ahead

export class Robot {
  onChange: () => void = () => {};

  seat: { driver: "you" | "other" | "nobody"; clients: number } = { driver: "nobody", clients: 0 };
  grid?: Grid;
  outline: [number, number][][] = [rectangle(0.89, 0.58, 0.038)]; // its convex parts
  planner: Sample[] = [];
  overruns = 0;
  collisions = 0;
  inContact = false;
  goal?: Pose; // the newest, from any publisher

  private mapOdom: Pose = { x: 0, y: 0, heading: 0 };
  private odomFrame = "odom";
  private odom?: Timed<{ pose: Pose; v: number; w: number }>;
  private timed = new Map<string, Timed<any>>();

  constructor(private connection: Connection) {}

  /** Listens to the robot of a namespace ("" or "/a"). */
  follow(namespace: string): void {
    const on = (topic: string, handler: (m: Message) => void) =>
      this.connection.subscribe(topic.startsWith("/") ? topic : `${namespace}/${topic}`, (m) => {
        handler(m);
        this.onChange();
      });
    const keep = (topic: string, convert: (m: Message) => unknown = (m) => m) =>
      on(topic, (m) => this.timed.set(topic, { value: convert(m), at: performance.now() }));
    on("map", (m) => (this.grid = picture(m)));
    on("goal_pose", (m) => (this.goal = pose(m.pose)));
    on("odom", (m) => this.onOdometry(m));
    // Robots that share a domain have a tf each, by remapping /tf to tf; else there is one for all.
    const own = `${namespace}/tf`;
    on("tf", (m) => this.onTransforms(m));
    if (namespace !== "") on("/tf", (m) => this.connection.hears(own) || this.onTransforms(m));
    on("collision", (m) => {
      this.collisions = m.count;
      this.inContact = m.in_contact;
    });
    on("planner/status", (m) => this.onPlanner(m));
    keep("planner/status");
    keep("arbitration/status");
    keep("safety_filter/status");
    keep("cmd_vel_user", (m) => (m.twist ?? m) as Message);
    keep("plan", (m) => m.poses.map((p: Message) => pose(p.pose)));
    keep("leader_pose", (m) => pose(m.pose));
    keep("joy/set_feedback", (m) => m.intensity);
    keep("obstacles", (m) => m.obstacles.map(obstacle));
    keep("hindsight/markers", (m) => m.markers.filter((marker: Message) => marker.text !== "").map(place));
  }

  /** The newest value of a topic, unless it is old. */
  get<T = Message>(topic: string, fresh = FRESH): T | undefined {
    const timed = this.timed.get(topic);
    return timed && performance.now() - timed.at < fresh ? (timed.value as T) : undefined;
  }

  get pose(): Pose | undefined {
    return this.odom && compose(this.mapOdom, this.odom.value.pose);
  }
  get speed(): { v: number; w: number } | undefined {
    return this.odom && performance.now() - this.odom.at < FRESH ? this.odom.value : undefined;
  }

  /** Where the person's command alone would lead. */
  ghost(): Pose[] {
    const twist = this.get("cmd_vel_user");
    const start = this.pose;
    if (!twist || !start) return [];
    const dt = GHOST / STEPS;
    const step = arc(twist.linear.x * dt, twist.angular.z * dt);
    const path = [start];
    for (let i = 0; i < STEPS; ++i) path.push(compose(path[i]!, step));
    return path;
  }

  /** The leader's pose as seen from the robot, in words. */
  leader(): string {
    const leader = this.get<Pose>("leader_pose"), pose = this.pose;
    if (!leader || !pose) return "No leader: hold the stick to send it ahead";
    const { x, y, heading } = relative(pose, leader);
    const turn = Math.round((Math.atan2(Math.sin(heading), Math.cos(heading)) * 180) / Math.PI) || 0; // no -0
    return (
      `Leader ${Math.abs(x).toFixed(2)} m ${x < 0 ? "behind" : "ahead"}, ${Math.abs(y).toFixed(2)} m to the ` +
      `${y < 0 ? "right" : "left"}, turned ${turn}°`
    );
  }

  private onTransforms(m: Message): void {
    for (const t of m.transforms)
      if (t.child_frame_id === this.odomFrame)
        this.mapOdom = pose({ position: t.transform.translation, orientation: t.transform.rotation });
  }

  private onOdometry(m: Message): void {
    const twist = m.twist.twist;
    this.odomFrame = m.header.frame_id;
    const value = { pose: pose(m.pose.pose), v: twist.linear.x, w: twist.angular.z };
    this.odom = { value, at: performance.now() };
  }

  private onPlanner(m: Message): void {
    const overruns = Number(m.overruns);
    const at = performance.now();
    this.planner.push({ at, solve: 1000 * m.solve_time, missed: overruns > this.overruns });
    this.overruns = overruns;
    while (this.planner.length > 0 && at - this.planner[0]!.at > HISTORY) this.planner.shift();
  }
}

export function rectangle(length: number, width: number, centre: number): [number, number][] {
  const front = centre + length / 2, back = centre - length / 2, side = width / 2;
  return [[front, -side], [front, side], [back, side], [back, -side]];
}

/** The parts of an outline from the parameters footprint and footprint_parts. */
export function polygons(coordinates: number[], counts: number[]): [number, number][][] {
  const vertices: [number, number][] = [];
  for (let i = 0; i + 1 < coordinates.length; i += 2) vertices.push([coordinates[i]!, coordinates[i + 1]!]);
  return counts.length === 0 ? [vertices] : counts.map((count) => vertices.splice(0, count));
}

export function compose(a: Pose, b: Pose): Pose {
  const c = Math.cos(a.heading), s = Math.sin(a.heading);
  return { x: a.x + c * b.x - s * b.y, y: a.y + s * b.x + c * b.y, heading: a.heading + b.heading };
}

/** b as seen from a. */
export function relative(a: Pose, b: Pose): Pose {
  const c = Math.cos(a.heading), s = Math.sin(a.heading), dx = b.x - a.x, dy = b.y - a.y;
  return { x: c * dx + s * dy, y: -s * dx + c * dy, heading: b.heading - a.heading };
}

function arc(way: number, turn: number): Pose {
  const chord = Math.abs(turn) < 1e-6 ? way : (2 * way * Math.sin(turn / 2)) / turn;
  return { x: chord * Math.cos(turn / 2), y: chord * Math.sin(turn / 2), heading: turn };
}

function pose(m: Message): Pose {
  const q = m.orientation;
  return {
    x: m.position.x,
    y: m.position.y,
    heading: Math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)),
  };
}

function place(m: Message): Place {
  return { pose: pose(m.pose), belief: m.text };
}

const RECTANGLE = 1; // tandem_msgs/Obstacle

function obstacle(m: Message): Obstacle {
  return {
    x: m.center.x,
    y: m.center.y,
    a: m.semi_axis_a,
    b: m.semi_axis_b,
    angle: m.angle,
    isRectangle: m.shape === RECTANGLE,
  };
}

// Occupied cells light, the rest clear; unknown a little.
function picture(m: Message): Grid {
  const { width, height, resolution, origin } = m.info;
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(width, height);
  m.data.forEach((cell: number, i: number) => {
    const at = 4 * ((height - 1 - Math.floor(i / width)) * width + (i % width));
    const shade = cell >= 50 ? [0xb8, 0xc4, 0xd0, 255] : cell < 0 ? [0x5a, 0x66, 0x72, 90] : [0, 0, 0, 0];
    image.data.set(shade, at);
  });
  context.putImageData(image, 0, 0);
  return { width, height, resolution, origin: pose(origin), frame: m.header.frame_id, picture: canvas };
}
