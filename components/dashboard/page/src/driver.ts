// SPDX-License-Identifier: Apache-2.0
// The person's hands: stick on the screen, keyboard, gamepad. One of them at a time, held to drive.
import type { Connection } from "./connection";

export interface Stick {
  linear: number; // [-1, 1] forward
  angular: number; // [-1, 1] left
}
/** Which axes and buttons of joy teleop reads, and what it makes of the axes. */
export interface Layout {
  axisLinear: number;
  axisAngular: number;
  deadmanButton: number; // -1: none
  endButton: number; // -1: none
  axisRange: number; // of an axis at full stick
  scaleLinear: number;
  scaleAngular: number;
}
export const USUAL: Layout = {
  axisLinear: 1, axisAngular: 0, deadmanButton: 0, endButton: 1, axisRange: 1, scaleLinear: 1, scaleAngular: 1,
};

/** Says what the stick is while it is held; nothing once it is let go. */
export interface Source {
  (): Stick | undefined;
  /**
   * It has a rest of its own, which must be seen before it drives. The others (keys, a finger) bring stick and
   * dead-man at once: their presses begin with a stick at rest.
   */
  rests?: boolean;
}

const PERIOD = 40; // [ms]
const RELEASES = 3; // messages that say "let go", for one may be lost
const FRESH = 3000; // [ms] a press that is older may have been held through a lost connection

export class Driver {
  /** The stick as it is being sent; undefined: nobody holds it. */
  stick?: Stick;
  onChange: () => void = () => {};
  enabled = true;
  /** undefined: not known yet, and nothing is sent. */
  layout?: Layout = USUAL;
  private releases = 0;
  private dropped = false;
  private source?: Source; // that holds the stick
  private pressed = 0; // [ms] when the stick was taken
  private begun = false; // teleop received this press

  constructor(
    private connection: Connection,
    private topic: () => string,
    private sources: Source[],
  ) {
    setInterval(() => this.beat(), PERIOD);
  }

  /** What is held now counts for nothing until it has been let go. */
  drop(): void {
    this.dropped = true;
  }

  /** Teleop has not seen the stick at rest: what the press began with was lost, or came too late to count. */
  beginAgain(): void {
    if (performance.now() - this.pressed < FRESH) this.begun = false;
  }

  private beat(): void {
    const before = this.stick, hand = this.source;
    const held = this.held();
    if (!held) this.dropped = false;
    const changes = hand !== undefined && hand !== this.source; // then it is let go of for a beat
    this.stick = document.hidden || !this.enabled || this.dropped || changes ? undefined : held;
    if (this.stick && !before) this.pressed = performance.now();
    if (this.stick) this.releases = RELEASES;
    else this.begun = false;
    if (this.stick || this.releases-- > 0) this.send();
    if (this.stick || before) this.onChange();
  }

  private held(): Stick | undefined {
    for (this.source of this.sources) {
      const stick = this.source();
      if (stick) return stick;
    }
    this.source = undefined;
    return undefined;
  }

  private send(): void {
    const layout = this.layout;
    if (!layout) return;
    const begins = this.stick !== undefined && !this.begun && !this.source?.rests;
    const { linear, angular } = begins || !this.stick ? { linear: 0, angular: 0 } : this.stick;
    const axes: number[] = [], buttons: number[] = [];
    // Forward stays forward where a joystick's axis is turned round.
    axes[layout.axisLinear] = layout.axisRange * (layout.scaleLinear < 0 ? -linear : linear);
    axes[layout.axisAngular] = layout.axisRange * (layout.scaleAngular < 0 ? -angular : angular);
    if (layout.endButton >= 0) buttons[layout.endButton] = 0;
    if (layout.deadmanButton >= 0) buttons[layout.deadmanButton] = this.stick ? 1 : 0;
    const sent = this.connection.publishFresh(this.topic(), "sensor_msgs/msg/Joy", {
      header: { stamp: this.connection.stamp(), frame_id: "dashboard" },
      axes: Array.from(axes, (value) => value ?? 0),
      buttons: Array.from(buttons, (value) => value ?? 0),
    });
    if (sent) this.begun = this.stick !== undefined;
  }
}

/** Shows where the stick is, also when keys or a gamepad hold it, and how strongly it resists: a ring around it. */
export function showStick(element: HTMLElement, knob: HTMLElement, stick?: Stick, resistance = 0): void {
  element.style.setProperty("--resistance", `${stick ? Math.round(22 * resistance) : 0}px`);
  const reach = element.offsetWidth / 2 - knob.offsetWidth / 2;
  element.classList.toggle("held", stick !== undefined);
  knob.style.transform = stick
    ? `translate(${-stick.angular * reach}px, ${-stick.linear * reach}px)`
    : "";
}

/** The stick on the screen: drag from its middle; letting go centres it. */
export function screenStick(element: HTMLElement, knob: HTMLElement): Source {
  let pointer: number | undefined;
  let box: DOMRect; // where it was when it was taken: the page may move under the finger
  let stick: Stick = { linear: 0, angular: 0 };
  const release = () => {
    pointer = undefined;
  };
  const move = (event: PointerEvent) => {
    const reach = box.width / 2 - knob.offsetWidth / 2;
    let x = (event.clientX - box.left - box.width / 2) / reach;
    let y = (event.clientY - box.top - box.height / 2) / reach;
    const length = Math.max(1, Math.hypot(x, y));
    x /= length;
    y /= length;
    stick = { linear: -y, angular: -x };
  };
  element.addEventListener("pointerdown", (event) => {
    if (pointer !== undefined || event.button !== 0) return;
    pointer = event.pointerId;
    box = element.getBoundingClientRect();
    element.setPointerCapture(pointer);
    move(event);
    event.preventDefault();
  });
  element.addEventListener("pointermove", (event) => {
    if (event.pointerId === pointer) move(event);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const)
    element.addEventListener(end, (event) => {
      if ((event as PointerEvent).pointerId === pointer) release();
    });
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  window.addEventListener("blur", release);
  return () => (pointer === undefined ? undefined : stick);
}

// teleop_twist_keyboard's keys, and the arrows.
const KEYS: Record<string, [number, number]> = {
  i: [1, 0], o: [1, -1], j: [0, 1], l: [0, -1], u: [1, 1], ",": [-1, 0], ".": [-1, 1], m: [-1, -1],
  ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1],
};
const SPEEDS: Record<string, [number, number]> = {
  q: [1.1, 1.1], z: [0.9, 0.9], w: [1.1, 1], x: [0.9, 1], e: [1, 1.1], c: [1, 0.9],
};

export class Keyboard {
  scale = { linear: 0.8, angular: 0.8 };
  onScale: () => void = () => {};
  private down = new Map<string, string>(); // what it stands for, by the key itself: Shift changes the former

  constructor() {
    window.addEventListener("keydown", (event) => this.press(event));
    window.addEventListener("keyup", (event) => this.down.delete(event.code || name(event)));
    // Whatever may keep a key's release from us lets go of all.
    for (const end of ["blur", "contextmenu"]) window.addEventListener(end, () => this.down.clear());
    document.addEventListener("visibilitychange", () => this.down.clear());
    document.addEventListener("focusin", (event) => {
      if ((event.target as HTMLElement).matches("select, input, textarea")) this.down.clear();
    });
  }

  readonly source: Source = () => {
    if (this.down.size === 0) return undefined;
    let linear = 0, angular = 0;
    for (const key of this.down.values()) {
      linear += KEYS[key]![0];
      angular += KEYS[key]![1];
    }
    return {
      linear: clamp(linear, 1) * this.scale.linear,
      angular: clamp(angular, 1) * this.scale.angular,
    };
  };

  private press(event: KeyboardEvent): void {
    // With such a key down, some systems do not tell that another one is let go.
    if (event.ctrlKey || event.altKey || event.metaKey) return this.down.clear();
    if (belongsToControl(event)) return;
    const key = name(event);
    if (key in KEYS) {
      this.down.set(event.code || key, key);
      event.preventDefault();
    } else if (key in SPEEDS) {
      this.scale.linear = Math.min(1, Math.max(0.05, this.scale.linear * SPEEDS[key]![0]));
      this.scale.angular = Math.min(1, Math.max(0.05, this.scale.angular * SPEEDS[key]![1]));
      this.onScale();
    } else if (key !== "Shift") {
      this.down.clear(); // any other key stops
    }
  }
}

function name(event: KeyboardEvent): string {
  return event.key.length === 1 ? event.key.toLowerCase() : event.key;
}

/** Whether the control that has the focus needs the key itself. */
export function belongsToControl(event: KeyboardEvent): boolean {
  const target = event.target;
  if (!(target instanceof HTMLElement)) return false;
  if (target.matches("input[type=radio]")) return event.key.startsWith("Arrow") || event.key === " ";
  if (target.matches("button, summary, input[type=checkbox]")) return event.key === " " || event.key === "Enter";
  if (event.key === " " && target.matches("input[type=range], input[type=number]")) return false;
  return target.matches("input, select, textarea");
}

function clamp(value: number, most: number): number {
  return Math.max(-most, Math.min(most, value));
}

/** A gamepad: left stick, held button 0 or a shoulder button. */
export function gamepad(onName: (name: string) => void): Source {
  let name = "";
  const source: Source = () => {
    const pad = navigator.getGamepads().find((p) => p?.connected);
    if ((pad?.id ?? "") !== name) onName((name = pad?.id ?? ""));
    if (!pad || !document.hasFocus()) return undefined;
    if (![0, 4, 5].some((i) => pad.buttons[i]?.pressed)) return undefined;
    return { linear: -(pad.axes[1] ?? 0), angular: -(pad.axes[0] ?? 0) };
  };
  source.rests = true;
  return source;
}
