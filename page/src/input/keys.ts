import { deflection, type Deflection } from "./deflection";

/** Keys that are down, by `KeyboardEvent.code`, and since when (ms). */
export type Keys = ReadonlyMap<string, number>;

export const NO_KEYS: Keys = new Map();

const FORWARD = ["ArrowUp", "KeyW"];
const BACK = ["ArrowDown", "KeyS"];
const LEFT = ["ArrowLeft", "KeyA"];
const RIGHT = ["ArrowRight", "KeyD"];
const STEERING = new Set([...FORWARD, ...BACK, ...LEFT, ...RIGHT]);

/** A key begins here and grows to full within RAMP ms (assumed); let go, it is 0 at once. */
const FIRST = 0.35;
const RAMP = 500;
/** Full turn of a key, share of full deflection (assumed): a whole one spins too fast to aim. */
const TURN = 0.6;

/** True if the key steers: arrows, and the positions of W, A, S and D on any keyboard. */
export function steers(code: string): boolean {
  return STEERING.has(code);
}

export function pressed(keys: Keys, code: string, now: number): Keys {
  return keys.has(code) ? keys : new Map(keys).set(code, now);
}

export function released(keys: Keys, code: string): Keys {
  const left = new Map(keys);
  left.delete(code);
  return left;
}

/** The deflection that the keys mean; opposite ones cancel. */
export function keyed(keys: Keys, now: number): Deflection {
  const forward = push(keys, FORWARD, BACK, now);
  const left = push(keys, LEFT, RIGHT, now);
  return deflection(forward, left * TURN);
}

function push(keys: Keys, plus: readonly string[], minus: readonly string[], now: number): number {
  const up = since(keys, plus);
  const down = since(keys, minus);
  if (up === null) return down === null ? 0 : -grown(now - down);
  return down === null ? grown(now - up) : 0;
}

function since(keys: Keys, codes: readonly string[]): number | null {
  const times = codes.map((code) => keys.get(code)).filter((time) => time !== undefined);
  return times.length > 0 ? Math.min(...times) : null;
}

function grown(held: number): number {
  return Math.min(1, FIRST + ((1 - FIRST) * Math.max(0, held)) / RAMP);
}

const TYPED = "input:not([type=button]):not([type=submit]):not([type=checkbox]), textarea, select";
const ARROWED =
  "[role=radio], [role=tab], [role=slider], [role=option], [role=listbox], [role=combobox], " +
  "[role=menuitem], [role=spinbutton], dialog";

/** True if arrows and letters belong to the focused field, list or dialog. */
export function isTyped(target: EventTarget | null): boolean {
  if (!(target instanceof Element)) return false;
  if (target instanceof HTMLElement && target.isContentEditable) return true;
  return target.closest(`${TYPED}, ${ARROWED}, [contenteditable=true]`) !== null;
}

/** True if Space and Enter belong to the focused control. */
export function isControl(target: EventTarget | null): boolean {
  if (!(target instanceof Element)) return false;
  return isTyped(target) || target.closest("button, a[href], summary, input, [role=button], [tabindex]:not([tabindex='-1'])") !== null;
}
