// SPDX-License-Identifier: Apache-2.0
// The picture: map, robot, what it sees, what the person asks for and what it intends.
import type { Obstacle, Place, Pose, Robot } from "./robot";

export type ViewMode = "follow" | "map" | "leader";

const FOLLOW_WIDTH = 8; // [m] across
const LEADER_WIDTH = 3.6; // [m]
const GRID = 1; // [m]
const LEAST_DRAG = 0.2; // [m]

// Okabe and Ito's colours, which colour-blind people tell apart.
const COLOR = {
  background: "#12171d",
  grid: "#1d252e",
  obstacle: "#cc79a7",
  ghost: "#e69f00",
  plan: "#56b4e9",
  leader: "#00b98a",
  robot: "#f2f5f7",
  contact: "#e8603c",
  text: "#c9d3dc",
};

export class View {
  mode: ViewMode = "map";
  drawn = 0; // pictures since the start
  draft?: Pose; // a goal that is being typed
  region?: { x0: number; y0: number; x1: number; y1: number }; // [m] to be reached
  private context: CanvasRenderingContext2D;
  private dirty = true;
  private scale = 50; // [px/m]
  private toCanvas = new DOMMatrix();

  constructor(
    private canvas: HTMLCanvasElement,
    private robot: Robot,
  ) {
    this.context = canvas.getContext("2d")!;
    new ResizeObserver(() => this.change()).observe(canvas);
    const frame = () => {
      if (this.dirty) this.draw();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** Calls `fn` with what is pointed out on the map: press for the place, drag for the heading. */
  onPoint(fn: (pose: Pose) => void): void {
    const place = (event: PointerEvent) =>
      this.toCanvas.inverse().transformPoint({ x: event.offsetX, y: event.offsetY });
    let from: DOMPoint | undefined;
    this.canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !this.canvas.classList.contains("points")) return;
      this.canvas.setPointerCapture(event.pointerId);
      from = place(event);
    });
    this.canvas.addEventListener("pointercancel", () => (from = undefined));
    this.canvas.addEventListener("pointerup", (event) => {
      if (!from) return;
      const { x, y } = from, to = place(event), robot = this.robot.pose;
      const dragged = Math.hypot(to.x - x, to.y - y) > LEAST_DRAG;
      const [dx, dy] = dragged ? [to.x - x, to.y - y] : [x - (robot?.x ?? 0), y - (robot?.y ?? 0)];
      from = undefined;
      fn({ x, y, heading: Math.atan2(dy, dx) });
    });
  }

  /** Whether there is anything to point out: then a finger does not move the page. */
  pointable(on: boolean): void {
    this.canvas.classList.toggle("points", on);
  }

  change(): void {
    this.dirty = true;
  }

  /** Where a point of the map is on the picture [px]. */
  place(x: number, y: number): { x: number; y: number } {
    return this.toCanvas.transformPoint({ x, y });
  }

  private draw(): void {
    this.dirty = false;
    ++this.drawn;
    const { canvas, context } = this;
    const density = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * density)) canvas.width = Math.round(width * density);
    if (canvas.height !== Math.round(height * density)) canvas.height = Math.round(height * density);
    context.setTransform(density, 0, 0, density, 0, 0);
    context.fillStyle = COLOR.background;
    context.fillRect(0, 0, width, height);
    this.look(width, height);
    this.toCanvas = new DOMMatrix().scale(1 / density).multiply(context.getTransform());
    this.drawGrid();
    this.drawMap();
    this.drawRegion();
    this.drawObstacles();
    this.path(this.robot.ghost(), COLOR.ghost, [6, 5]);
    this.drawPlaces();
    this.drawGoal();
    this.drawLeader();
    this.drawRobot();
    this.path(this.robot.get<Pose[]>("plan") ?? [], COLOR.plan, [], true);
    context.setTransform(density, 0, 0, density, 0, 0);
    this.drawScale(width);
  }

  // Puts metres of the map onto the canvas: follow and leader with the robot in the middle, heading up.
  private look(width: number, height: number): void {
    const { context, robot } = this;
    const grid = robot.grid, pose = robot.pose;
    context.translate(width / 2, height / 2);
    if (this.mode !== "map" && pose) {
      const across = this.mode === "follow" ? FOLLOW_WIDTH : LEADER_WIDTH;
      this.scale = Math.min(width, height) / across;
      context.scale(this.scale, -this.scale);
      context.rotate(Math.PI / 2 - pose.heading); // heading up
      context.translate(-pose.x, -pose.y);
      return;
    }
    if (grid) {
      const w = grid.width * grid.resolution, h = grid.height * grid.resolution;
      const { left, top, right, bottom } = this.margins(width, height);
      context.translate((left - right) / 2, (top - bottom) / 2);
      this.scale = Math.min((width - left - right) / w, (height - top - bottom) / h);
      context.scale(this.scale, -this.scale);
      context.translate(-grid.origin.x - w / 2, -grid.origin.y - h / 2);
    } else {
      this.scale = Math.min(width, height) / 10;
      context.scale(this.scale, -this.scale);
      if (pose) context.translate(-pose.x, -pose.y);
    }
  }

  // What buttons, legend and stick lie on.
  private margins(width: number, height: number) {
    const stick = 222; // [px]
    const wide = width > 1.2 * height;
    return { left: 12, top: 58, right: wide ? stick : 12, bottom: wide ? 48 : stick };
  }

  private px(pixels: number): number {
    return pixels / this.scale;
  }

  private drawGrid(): void {
    const { context, robot } = this;
    const middle = this.mode === "map" ? robot.grid?.origin : robot.pose;
    const x0 = Math.floor(middle?.x ?? 0), y0 = Math.floor(middle?.y ?? 0), reach = 40;
    context.strokeStyle = COLOR.grid;
    context.lineWidth = this.px(1);
    context.beginPath();
    for (let i = -reach; i <= reach; i += GRID) {
      context.moveTo(x0 + i, y0 - reach);
      context.lineTo(x0 + i, y0 + reach);
      context.moveTo(x0 - reach, y0 + i);
      context.lineTo(x0 + reach, y0 + i);
    }
    context.stroke();
  }

  private drawMap(): void {
    const { context } = this, grid = this.robot.grid;
    if (!grid) return;
    const w = grid.width * grid.resolution, h = grid.height * grid.resolution;
    context.save();
    context.imageSmoothingEnabled = false;
    context.translate(grid.origin.x, grid.origin.y);
    context.rotate(grid.origin.heading);
    context.scale(1, -1);
    context.drawImage(grid.picture, 0, -h, w, h);
    context.restore();
  }

  private drawRegion(): void {
    if (!this.region) return;
    const { context } = this, { x0, y0, x1, y1 } = this.region;
    context.fillStyle = COLOR.leader + "26";
    context.strokeStyle = COLOR.leader;
    context.lineWidth = this.px(2);
    context.fillRect(x0, y0, x1 - x0, y1 - y0);
    context.strokeRect(x0, y0, x1 - x0, y1 - y0);
  }

  private drawObstacles(): void {
    const { context } = this;
    context.lineWidth = this.px(1.5);
    context.strokeStyle = COLOR.obstacle;
    context.fillStyle = COLOR.obstacle + "2e";
    for (const o of this.robot.get<Obstacle[]>("obstacles", 1000) ?? []) {
      context.save();
      context.translate(o.x, o.y);
      context.rotate(o.angle);
      context.beginPath();
      if (o.isRectangle) context.rect(-o.a, -o.b, 2 * o.a, 2 * o.b);
      else context.ellipse(0, 0, o.a, o.b, 0, 0, 2 * Math.PI);
      context.restore();
      context.fill();
      context.stroke();
    }
  }

  private path(poses: Pose[], color: string, dashes: number[], dots = false): void {
    if (poses.length < 2) return;
    const { context } = this;
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = this.px(3);
    context.lineJoin = context.lineCap = "round";
    context.setLineDash(dashes.map((d) => this.px(d)));
    context.beginPath();
    poses.forEach((p, i) => (i === 0 ? context.moveTo(p.x, p.y) : context.lineTo(p.x, p.y)));
    context.stroke();
    context.setLineDash([]);
    if (!dots) return;
    for (const p of poses) {
      context.beginPath();
      context.arc(p.x, p.y, this.px(2.5), 0, 2 * Math.PI);
      context.fill();
    }
  }

  private drawGoal(): void {
    const { context, robot, draft } = this;
    context.strokeStyle = context.fillStyle = COLOR.plan;
    if (robot.goal && robot.get("planner/status")?.method === "goal") this.target(robot.goal);
    context.setLineDash([this.px(4), this.px(4)]);
    if (draft) this.target(draft);
    context.setLineDash([]);
  }

  private target(at: Pose): void {
    const { context } = this;
    context.lineWidth = this.px(2);
    context.beginPath();
    context.arc(at.x, at.y, 0.4, 0, 2 * Math.PI);
    context.stroke();
    this.arrow(at, 0.28);
  }

  // Where the person may mean to go, and how likely that is.
  private drawPlaces(): void {
    const { context } = this;
    context.font = "13px system-ui, sans-serif";
    context.textAlign = "center";
    for (const { pose, belief } of this.robot.get<Place[]>("hindsight/markers", 2000) ?? []) {
      context.strokeStyle = context.fillStyle = COLOR.leader;
      this.target(pose);
      const { x, y } = context.getTransform().transformPoint({ x: pose.x, y: pose.y });
      const density = window.devicePixelRatio || 1;
      context.save();
      context.setTransform(density, 0, 0, density, 0, 0);
      context.strokeStyle = COLOR.background;
      context.lineWidth = 4;
      context.strokeText(belief, x / density, y / density - 0.4 * this.scale - 6);
      context.fillStyle = COLOR.text;
      context.fillText(belief, x / density, y / density - 0.4 * this.scale - 6);
      context.restore();
    }
  }

  private drawLeader(): void {
    const leader = this.robot.get<Pose>("leader_pose"), pose = this.robot.pose;
    if (!leader || !pose) return;
    const { context } = this;
    context.strokeStyle = context.fillStyle = COLOR.leader;
    context.lineWidth = this.px(1.5);
    context.setLineDash([this.px(2), this.px(4)]);
    context.beginPath();
    context.moveTo(pose.x, pose.y);
    context.lineTo(leader.x, leader.y);
    context.stroke();
    context.setLineDash([]);
    this.arrow(leader, 0.28);
  }

  private arrow(at: Pose, size: number): void {
    const { context } = this;
    context.save();
    context.translate(at.x, at.y);
    context.rotate(at.heading);
    context.beginPath();
    context.moveTo(size, 0);
    context.lineTo(-size * 0.6, size * 0.5);
    context.lineTo(-size * 0.3, 0);
    context.lineTo(-size * 0.6, -size * 0.5);
    context.closePath();
    context.fill();
    context.restore();
  }

  private drawRobot(): void {
    const { context, robot } = this, pose = robot.pose;
    if (!pose) return;
    context.save();
    context.translate(pose.x, pose.y);
    context.rotate(pose.heading);
    context.beginPath();
    for (const part of robot.outline) {
      part.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
      context.closePath();
    }
    context.fillStyle = (robot.inContact ? COLOR.contact : COLOR.robot) + "40";
    context.strokeStyle = robot.inContact ? COLOR.contact : COLOR.robot;
    context.lineWidth = this.px(2);
    context.fill();
    context.stroke();
    context.restore();
    context.fillStyle = robot.inContact ? COLOR.contact : COLOR.robot;
    this.arrow(pose, 0.16);
  }

  private drawScale(width: number): void {
    const { context } = this;
    const length = this.scale > 150 ? 0.5 : 1;
    const x = width - 16, y = 36;
    context.strokeStyle = context.fillStyle = COLOR.text;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x - length * this.scale, y - 4);
    context.lineTo(x - length * this.scale, y);
    context.lineTo(x, y);
    context.lineTo(x, y - 4);
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "right";
    context.fillText(`${length} m`, x, y - 9);
  }
}

/** Planner times of the last seconds, misses marked; what took very long is cut off. */
export function drawPlot(canvas: HTMLCanvasElement, robot: Robot): void {
  const density = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (width === 0) return;
  canvas.width = width * density;
  canvas.height = height * density;
  const context = canvas.getContext("2d")!;
  context.scale(density, density);
  const now = performance.now(), span = 20_000;
  const most = Math.min(60, Math.max(5, ...robot.planner.map((s) => s.solve)) * 1.15);
  const x = (at: number) => width * (1 - (now - at) / span);
  const y = (solve: number) => height - 2 - (height - 16) * (solve / most);
  context.fillStyle = COLOR.text;
  context.font = "11px system-ui, sans-serif";
  context.fillText(`${most.toFixed(0)} ms`, 2, 10);
  context.strokeStyle = COLOR.plan;
  context.lineWidth = 1.2;
  context.beginPath();
  robot.planner.forEach((s, i) =>
    i === 0 ? context.moveTo(x(s.at), y(s.solve)) : context.lineTo(x(s.at), y(s.solve)),
  );
  context.stroke();
  context.fillStyle = COLOR.contact;
  for (const s of robot.planner)
    if (s.missed) context.fillRect(x(s.at) - 1.5, 0, 3, height);
}
