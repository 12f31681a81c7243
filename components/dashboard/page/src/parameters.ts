// SPDX-License-Identifier: Apache-2.0
// Sliders for what may change while the robot drives, made from the nodes' own descriptions.
import type { Connection, Message } from "./connection";

const BOOL = 1, INTEGER = 2, DOUBLE = 3, STRING = 4;
const DESCRIBE = "/describe_parameters";

type Value = number | boolean | string;
type Setter = (next: Value) => Promise<boolean>;

interface Parameter {
  name: string;
  type: number;
  description: string;
  min: number;
  max: number;
  step: number;
  choices: string[];
}

/** Names of the nodes that have parameters. */
export function nodesWithParameters(connection: Connection): string[] {
  return connection
    .serviceNames()
    .filter((name) => name.endsWith(DESCRIBE))
    .map((name) => name.slice(0, -DESCRIBE.length))
    .sort();
}

/** The values that a text may have by its description; none: any. */
export function choicesOf(descriptor: Message): string[] {
  return /^one of \{(.*)\}$/.exec(descriptor.additional_constraints)?.[1]?.split(", ") ?? [];
}

async function setParameter(connection: Connection, node: string, name: string, value: Message): Promise<void> {
  const { results } = await connection.call(`${node}/set_parameters`, { parameters: [{ name, value }] });
  if (!results[0].successful) throw new Error(results[0].reason);
}

/** Sets one text parameter of a node. Throws an Error that says why it could not. */
export function setText(connection: Connection, node: string, name: string, text: string): Promise<void> {
  return setParameter(connection, node, name, parameterValue(STRING, text));
}

/** Fills `list` with the controls of a node's live parameters. */
export async function showParameters(
  connection: Connection,
  node: string,
  list: HTMLElement,
  say: (text: string) => void,
): Promise<void> {
  list.textContent = "…";
  list.dataset.node = node;
  const { result } = await connection.call(`${node}/list_parameters`, { prefixes: [], depth: 0n });
  const { descriptors } = await connection.call(`${node}/describe_parameters`, { names: result.names });
  const live = (descriptors as Message[]).filter(
    (d) => !d.read_only && ([BOOL, INTEGER, DOUBLE].includes(d.type) || choicesOf(d).length > 0),
  );
  const { values } = await connection.call(`${node}/get_parameters`, { names: live.map((d) => d.name) });
  if (list.dataset.node !== node) return; // another one was asked for meanwhile
  list.textContent = live.length === 0 ? "Nothing here can be changed while the robot drives." : "";
  live.forEach((d, i) => list.append(control(connection, node, parameter(d), values[i], say)));
}

function parameter(d: Message): Parameter {
  const range = d.floating_point_range[0] ?? d.integer_range[0];
  return {
    name: d.name,
    type: d.type,
    description: d.description,
    min: Number(range?.from_value ?? -1e6),
    max: Number(range?.to_value ?? 1e6),
    step: d.type === INTEGER ? 1 : 0,
    choices: choicesOf(d),
  };
}

function control(
  connection: Connection,
  node: string,
  p: Parameter,
  value: Message,
  say: (text: string) => void,
): HTMLElement {
  const row = document.createElement("label");
  row.className = "parameter";
  row.title = p.description;
  const title = document.createElement("span");
  title.textContent = p.name;
  row.append(title);
  const set: Setter = (next) =>
    setParameter(connection, node, p.name, parameterValue(p.type, next)).then(
      () => (say(`${p.name} is ${next}`), true),
      (error: Error) => (say(error.message), false),
    );
  if (p.type === BOOL) row.append(checkbox(value.bool_value, set));
  else if (p.type === STRING) row.append(choice(p, value.string_value, set));
  else row.append(...slider(p, Number(p.type === INTEGER ? value.integer_value : value.double_value), set));
  const meaning = document.createElement("small");
  meaning.textContent = p.description;
  row.append(meaning);
  return row;
}

function choice(p: Parameter, chosen: string, set: Setter): HTMLSelectElement {
  const select = document.createElement("select");
  select.append(...p.choices.map((name) => new Option(name)));
  select.value = chosen;
  select.onchange = async () => {
    if (await set(select.value)) chosen = select.value;
    select.value = chosen;
  };
  return select;
}

function checkbox(checked: boolean, set: Setter): HTMLInputElement {
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = checked;
  box.onchange = async () => {
    if (!(await set(box.checked))) box.checked = !box.checked;
  };
  return box;
}

// A slider over the whole range is useless where the range is wide: its way is then logarithmic.
function slider(
  p: Parameter,
  start: number,
  set: Setter,
): [HTMLInputElement, HTMLInputElement] {
  let value = start;
  const least = Math.max(p.min, p.max * 1e-6);
  const logarithmic = p.min >= 0 && p.max > 100 * Math.max(Math.abs(start), 1e-3);
  const toWay = (v: number) =>
    logarithmic ? Math.log(Math.max(v, least) / least) / Math.log(p.max / least) : (v - p.min) / (p.max - p.min);
  const toValue = (way: number) => {
    const v = logarithmic ? (way <= 0 ? p.min : least * (p.max / least) ** way) : p.min + way * (p.max - p.min);
    return p.step === 1 ? Math.round(v) : Number(v.toPrecision(3));
  };
  const range = document.createElement("input");
  range.type = "range";
  range.min = "0";
  range.max = "1";
  range.step = "0.001";
  const number = document.createElement("input");
  number.type = "number";
  number.step = "any";
  const show = () => {
    range.value = String(toWay(value));
    number.value = String(value);
  };
  const change = async (next: number) => {
    if (await set(next)) value = next;
    show();
  };
  range.oninput = () => (number.value = String(toValue(Number(range.value))));
  range.onchange = () => void change(toValue(Number(range.value)));
  number.onchange = () => void change(Number(number.value));
  show();
  return [range, number];
}

function parameterValue(type: number, next: Value): Message {
  return {
    type,
    bool_value: type === BOOL ? next : false,
    integer_value: type === INTEGER ? BigInt(next as number) : 0n,
    double_value: type === DOUBLE ? next : 0,
    string_value: type === STRING ? next : "",
    byte_array_value: [],
    bool_array_value: [],
    integer_array_value: [],
    double_array_value: [],
    string_array_value: [],
  };
}
