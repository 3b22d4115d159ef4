import type { ChairState } from "../messages";
import { CENTRE, isCentred, type Deflection } from "./deflection";

/** A device that can steer; each gamepad is one of its own. */
export type Source = "joystick" | "keys" | "switch" | `gamepad:${number}`;
export type Device = ChairState["device"];

interface Stick {
  readonly at: Deflection;
  /** Seen at its centre since it was connected, since the page was left, since it looked dead, and
   * since it last moved out of turn: only then does it count. */
  readonly armed: boolean;
}

/** The source in control; the others wait until it and they themselves are centred. */
export interface Arbiter {
  readonly control: Source | null;
  readonly sticks: ReadonlyMap<Source, Stick>;
}

export interface Steering {
  readonly at: Deflection;
  readonly device: Device;
  /** Deflected but not heeded: these must be let go first. */
  readonly waiting: readonly Source[];
}

/** Nobody steers. Finger, keys and switches begin at their centre; a gamepad has to show it. */
export const NOBODY: Arbiter = {
  control: null,
  sticks: new Map(
    (["joystick", "keys", "switch"] as const).map((source) => [source, { at: CENTRE, armed: true }]),
  ),
};

/** A source has been read.
 *
 * One that leaves its centre takes over where it was centred before and the one in control is
 * centred now; where it is not, it has to come back to its centre before it counts. */
export function read(was: Arbiter, source: Source, at: Deflection, deadZone: number): Arbiter {
  const stick = was.sticks.get(source);
  if (isCentred(at, deadZone)) return set(was, was.control, source, { at, armed: true });
  if (was.control === source || !stick?.armed) {
    return set(was, was.control, source, { at, armed: stick?.armed ?? false });
  }
  const other = was.control === null ? undefined : was.sticks.get(was.control);
  const free = !other || !other.armed || isCentred(other.at, deadZone);
  return free
    ? set(was, source, source, { at, armed: true })
    : set(was, was.control, source, { at, armed: false });
}

/** A source is no longer there. */
export function gone(was: Arbiter, source: Source): Arbiter {
  const sticks = new Map(was.sticks);
  sticks.delete(source);
  return { control: was.control === source ? null : was.control, sticks };
}

/** The page was left, or one source looks dead: it does not steer, and has to show its centre again. */
export function dropped(was: Arbiter, only?: Source): Arbiter {
  const drops = (source: Source | null) => only === undefined || source === only;
  const sticks = new Map([...was.sticks].map(([s, stick]) => [s, drops(s) ? { ...stick, armed: false } : stick]));
  return { control: drops(was.control) ? null : was.control, sticks };
}

/** Deflection sent to the chair, and the sources that must be released first. */
export function steering(arbiter: Arbiter, deadZone: number): Steering {
  const waiting = [...arbiter.sticks]
    .filter(([, stick]) => !stick.armed && !isCentred(stick.at, deadZone))
    .map(([source]) => source);
  const stick = arbiter.control === null ? undefined : arbiter.sticks.get(arbiter.control);
  if (arbiter.control === null || !stick?.armed || isCentred(stick.at, deadZone)) {
    return { at: CENTRE, device: "none", waiting };
  }
  return { at: stick.at, device: deviceOf(arbiter.control), waiting };
}

export function deviceOf(source: Source): Device {
  return source.startsWith("gamepad:") ? "gamepad" : (source as Device);
}

function set(was: Arbiter, control: Source | null, source: Source, stick: Stick): Arbiter {
  return { control, sticks: new Map(was.sticks).set(source, stick) };
}
