import { deflection, type Deflection } from "./deflection";
import { PUSHES } from "./switches";

/** Fields of the web platform's `Gamepad` that are read. */
export interface Pad {
  readonly index: number;
  readonly connected: boolean;
  readonly mapping: string;
  readonly timestamp: number;
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean; readonly value: number }[];
}

/** A gamepad as it was read last: the browser may change the object that it gave. */
export interface PadReading {
  /** Buttons that are pressed, by number. */
  readonly down: readonly boolean[];
  /** Axes and buttons. */
  readonly content: readonly number[];
  readonly timestamp: number;
  /** When axes or buttons last changed, ms. */
  readonly changed: number;
  /** When they or the timestamp last changed, ms. */
  readonly stamped: number;
}

/** Command buttons of a gamepad. */
export interface PadButtons {
  readonly stop: boolean;
  readonly resume: boolean;
}

/** Standard mapping: https://www.w3.org/TR/gamepad/#remapping */
const FACE = [0, 1, 2, 3];
const START = 9;
const [UP, DOWN, LEFT, RIGHT] = [12, 13, 14, 15] as const;
/** Deflection of the D-pad (assumed). */
const CROSS = 0.6;
/** A deflected gamepad without any change for longer than this is taken for dead, ms (assumed): a hand on
 * an analogue stick trembles by more than its resolution; `StickParameters.renew` of a Joy. */
const UNCHANGED = 5_000;
/** The same for a stick that a hand can hold bit for bit, and where only the timestamp goes on, ms: the
 * longest push of a switch. */
const CONSTANT = PUSHES.forward.longest;
/** So near to its end or its centre an axis has no play: 1.3 steps of an axis with 8 bits (assumed). */
const DETENT = 0.01;

/** Left stick, or the cross where the stick rests. Its axes point right and down. */
export function padDeflection(pad: Pad): Deflection {
  return cross(pad) ?? deflection(-(pad.axes[1] ?? 0), -(pad.axes[0] ?? 0));
}

/** The reading after `was`. */
export function padReading(pad: Pad, was: PadReading | undefined, now: number): PadReading {
  const { timestamp } = pad;
  const down = pad.buttons.map((button) => button.pressed);
  const content = [...pad.axes, ...pad.buttons.flatMap((button) => [Number(button.pressed), button.value])];
  const same = content.length === was?.content.length && content.every((x, n) => Object.is(x, was.content[n]));
  const changed = was && same ? was.changed : now;
  const stamped = was && same && timestamp === was.timestamp ? was.stamped : now;
  return { down, content, timestamp, changed, stamped };
}

/** True if the gamepad looks dead: one that lost its link repeats its last state, and stays connected.
 *
 * Some browsers stamp each reading, so that the timestamp alone is a weak sign of life. */
export function isFrozen(pad: Pad, reading: PadReading, now: number): boolean {
  const digital = cross(pad) !== null || pad.axes.slice(0, 2).every((x) => Math.abs(x - Math.round(x)) < DETENT);
  return now - reading.changed > CONSTANT || (!digital && now - reading.stamped > UNCHANGED);
}

/** Newly pressed commands; each button has an edge of its own, so that one that is stuck masks no other.
 *
 * Any of the four large buttons is STOP and Start is “Go on”; on a device whose buttons are not
 * known, every one is STOP. A button held while the gamepad connects stops the chair, but it never
 * goes on. */
export function newlyPressed(pad: Pad, was: PadReading | undefined): PadButtons {
  const pressed = (button: number) => down(pad, button) === 1 && !was?.down[button];
  if (pad.mapping !== "standard") return { stop: pad.buttons.some((_, n) => pressed(n)), resume: false };
  return { stop: FACE.some(pressed), resume: pressed(START) && was?.down[START] === false };
}

/** The reading for a page that comes back: Start may have been pressed for another one. */
export function withStartDown(reading: PadReading): PadReading {
  return { ...reading, down: reading.down.map((pressed, n) => pressed || n === START) };
}

/** The gamepads that are there; none where the browser does not say. */
export function connectedPads(source: Pick<Navigator, "getGamepads">): Pad[] {
  try {
    return [...source.getGamepads()].filter((pad): pad is Gamepad => pad !== null && pad.connected);
  } catch {
    return []; // forbidden by policy, or not there at all
  }
}

/** Deflection of the cross; null: there is none, or it rests. */
function cross(pad: Pad): Deflection | null {
  if (pad.mapping !== "standard") return null;
  const forward = down(pad, UP) - down(pad, DOWN);
  const left = down(pad, LEFT) - down(pad, RIGHT);
  return forward === 0 && left === 0 ? null : deflection(forward * CROSS, left * CROSS);
}

function down(pad: Pad, button: number): 0 | 1 {
  return pad.buttons[button]?.pressed ? 1 : 0;
}
