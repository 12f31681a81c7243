// SPDX-License-Identifier: Apache-2.0
// A client of foxglove.websocket.v1: topics in, topics out, services. Reconnects by itself.
import { parse } from "@foxglove/rosmsg";
import { MessageReader, MessageWriter } from "@foxglove/rosmsg2-serialization";

import { DEFINITIONS } from "./definitions";

export type Message = any; // as its ROS 2 type says

interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
}
interface Service {
  id: number;
  name: string;
  type: string;
  request: { schema: string };
  response: { schema: string };
}
interface Subscription {
  topic: string;
  handler: (message: Message) => void;
  channel?: number; // the server's number while subscribed
  decode?: (bytes: DataView) => Message;
}
interface Outlet {
  id: number;
  type: string;
  encoding: string;
  encode: (message: Message) => Uint8Array;
}
interface Call {
  decode: (bytes: DataView) => Message;
  resolve: (message: Message) => void;
  reject: (reason: Error) => void;
  timer: number;
}

const SUBPROTOCOL = "foxglove.websocket.v1";
const SILENCE = 1500; // [ms] without a frame of the server: the connection is lost
const RETRY = 1000; // [ms]
const CALL_TIMEOUT = 6000; // [ms]
const OP = { message: 1, time: 2, response: 3 };
const SEND = { message: 1, call: 2 };

const text = new TextDecoder();

export class Connection {
  onState: (connected: boolean) => void = () => {};
  onStatus: (message: string) => void = () => {};
  onServices: () => void = () => {};
  connected = false;

  private socket?: WebSocket;
  private channels = new Map<number, Channel>();
  private services = new Map<string, Service>();
  private subscriptions: Subscription[] = []; // by subscription number
  private outlets = new Map<string, Outlet>();
  private calls = new Map<number, Call>();
  private lastCall = 0;
  private heard = 0;
  private robotTime = 0n; // [ns] the robot's clock when it sent the newest message

  constructor(private url: string) {
    this.open();
    setInterval(() => this.watch(), 250);
  }

  /** Topics are full names; the handler is called for each message, also after a reconnect. */
  subscribe(topic: string, handler: (message: Message) => void): void {
    this.subscriptions.push({ topic, handler });
    for (const channel of this.channels.values()) this.match(channel);
  }

  /** The name of the topic whose messages are of a type, if there is one. */
  topicOf(schemaName: string): string | undefined {
    for (const channel of this.channels.values())
      if (channel.schemaName === schemaName) return channel.topic;
    return undefined;
  }

  /** Whether somebody publishes the topic. */
  hears(topic: string): boolean {
    for (const channel of this.channels.values()) if (channel.topic === topic) return true;
    return false;
  }

  /** Whether a server offers the service. */
  has(service: string): boolean {
    return this.services.has(service);
  }
  serviceNames(): string[] {
    return [...this.services.keys()];
  }

  /** Publishes a message unless older ones still wait in this machine: for what ages. False: not sent. */
  publishFresh(topic: string, type: string, message: Message): boolean {
    return this.socket?.bufferedAmount === 0 && this.publish(topic, type, message);
  }

  /** Publishes a message; false: there is no connection. */
  publish(topic: string, type: string, message: Message): boolean {
    const socket = this.socket;
    if (!this.connected || !socket) return false;
    let outlet = this.outlets.get(topic);
    if (!outlet) {
      outlet = makeOutlet(this.outlets.size + 1, type);
      this.outlets.set(topic, outlet);
      this.advertise(topic);
    }
    const payload = outlet.encode(message);
    const frame = new Uint8Array(5 + payload.length);
    frame[0] = SEND.message;
    new DataView(frame.buffer).setUint32(1, outlet.id, true);
    frame.set(payload, 5);
    socket.send(frame);
    return true;
  }

  /** The newest time heard from the robot, as a stamp. */
  stamp(): { sec: number; nanosec: number } {
    return {
      sec: Number(this.robotTime / 1_000_000_000n),
      nanosec: Number(this.robotTime % 1_000_000_000n),
    };
  }

  call(name: string, request: Message): Promise<Message> {
    const service = this.services.get(name);
    if (!service || !this.connected) return Promise.reject(new Error(`${name} is not there`));
    const payload = writer(service.request.schema).writeMessage(request);
    const id = ++this.lastCall;
    const frame = new Uint8Array(16 + payload.length);
    const view = new DataView(frame.buffer);
    frame[0] = SEND.call;
    view.setUint32(1, service.id, true);
    view.setUint32(5, id, true);
    view.setUint32(9, 3, true);
    frame.set([0x63, 0x64, 0x72], 13); // "cdr"
    frame.set(payload, 16);
    return new Promise((resolve, reject) => {
      const timer = window.setTimeout(
        () => this.fail(id, `${name} does not answer`),
        CALL_TIMEOUT,
      );
      this.calls.set(id, { decode: decoder(service.response.schema), resolve, reject, timer });
      this.socket!.send(frame);
    });
  }

  private open(): void {
    const socket = new WebSocket(this.url, [SUBPROTOCOL]);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.heard = performance.now();
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heard = performance.now();
      if (typeof event.data === "string") this.onText(JSON.parse(event.data));
      else this.onBinary(new DataView(event.data));
    };
    socket.onclose = () => this.lose(socket);
  }

  // A network that is gone closes nothing: silence is the sign.
  private watch(): void {
    if (this.socket && performance.now() - this.heard > SILENCE) {
      const socket = this.socket;
      this.lose(socket);
      socket.close();
    }
  }

  private lose(socket: WebSocket): void {
    if (socket !== this.socket) return;
    this.socket = undefined;
    this.connected = false;
    this.channels.clear();
    this.services.clear();
    this.outlets.clear();
    for (const subscription of this.subscriptions) subscription.channel = undefined;
    for (const id of [...this.calls.keys()]) this.fail(id, "the connection is lost");
    this.onState(false);
    window.setTimeout(() => this.open(), RETRY);
  }

  private fail(id: number, reason: string): void {
    const call = this.calls.get(id);
    this.calls.delete(id);
    if (!call) return;
    clearTimeout(call.timer);
    call.reject(new Error(reason));
  }

  private onText(frame: any): void {
    switch (frame.op) {
      case "serverInfo":
        this.connected = true;
        this.onState(true);
        break;
      case "status":
        this.onStatus(frame.message);
        break;
      case "advertise":
        for (const channel of frame.channels as Channel[]) {
          this.channels.set(channel.id, channel);
          this.match(channel);
        }
        break;
      case "unadvertise":
        for (const id of frame.channelIds as number[]) {
          this.channels.delete(id);
          for (const s of this.subscriptions) if (s.channel === id) s.channel = undefined;
        }
        break;
      case "advertiseServices":
        for (const service of frame.services as Service[]) this.services.set(service.name, service);
        this.onServices();
        break;
      case "unadvertiseServices":
        for (const [name, service] of this.services)
          if (frame.serviceIds.includes(service.id)) this.services.delete(name);
        this.onServices();
        break;
      case "serviceCallFailure":
        this.fail(frame.callId, frame.message);
        break;
    }
  }

  private onBinary(frame: DataView): void {
    const op = frame.getUint8(0);
    if (op === OP.message) {
      const subscription = this.subscriptions[frame.getUint32(1, true)];
      this.robotTime = frame.getBigUint64(5, true);
      if (subscription?.decode) subscription.handler(subscription.decode(tail(frame, 13)));
    } else if (op === OP.response) {
      const call = this.calls.get(frame.getUint32(5, true));
      this.calls.delete(frame.getUint32(5, true));
      if (!call) return;
      clearTimeout(call.timer);
      call.resolve(call.decode(tail(frame, 13 + frame.getUint32(9, true))));
    }
  }

  private match(channel: Channel): void {
    this.subscriptions.forEach((subscription, id) => {
      if (subscription.topic !== channel.topic || subscription.channel !== undefined) return;
      subscription.channel = channel.id;
      subscription.decode = channel.encoding === "json" ? json : decoder(channel.schema);
      this.say({ op: "subscribe", subscriptions: [{ id, channelId: channel.id }] });
    });
  }

  private advertise(topic: string): void {
    const { id, type, encoding } = this.outlets.get(topic)!;
    this.say({ op: "advertise", channels: [{ id, topic, encoding, schemaName: type }] });
  }

  private say(request: object): void {
    this.socket?.send(JSON.stringify(request));
  }
}

function tail(frame: DataView, at: number): DataView {
  return new DataView(frame.buffer, frame.byteOffset + at, frame.byteLength - at);
}

function json(bytes: DataView): Message {
  return JSON.parse(text.decode(bytes));
}

// In CDR if it is a ROS 2 type that the page knows, else in JSON.
function makeOutlet(id: number, type: string): Outlet {
  const definition = DEFINITIONS[type];
  if (definition === undefined) {
    const encode = (message: Message) => new TextEncoder().encode(JSON.stringify(message));
    return { id, type, encoding: "json", encode };
  }
  const cdr = writer(definition);
  return { id, type, encoding: "cdr", encode: (message) => cdr.writeMessage(message) };
}

const decoders = new Map<string, (bytes: DataView) => Message>();

function decoder(schema: string): (bytes: DataView) => Message {
  let known = decoders.get(schema);
  if (!known) {
    const reader = new MessageReader(parse(schema, { ros2: true }));
    known = (bytes) => reader.readMessage(bytes);
    decoders.set(schema, known);
  }
  return known;
}

function writer(schema: string): MessageWriter {
  return new MessageWriter(parse(schema, { ros2: true }));
}
