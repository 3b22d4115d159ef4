import type { ChairState } from "../messages";
import { CENTRE, type Deflection } from "./deflection";

/** Switch settings of this device, stored on it only. */
export interface SwitchSettings {
  /** Number of switches; 0: no scanning. */
  readonly count: 0 | 1 | 2;
  /** Drive only while the switch is held; else until it is pressed again. */
  readonly hold: boolean;
  /** `KeyboardEvent.code` of the switch that chooses, and of the one that steps. */
  readonly choose: string;
  readonly step: string;
  /** Time in which a switch bounces, ms. */
  readonly bounce: number;
}

/** Maximum of the bounce time, ms: nobody presses twice on purpose within it (assumed). */
export const MAX_BOUNCE = 300;
/** Bounces of 80 ms are known. */
export const NO_SWITCH: SwitchSettings = { count: 0, hold: false, choose: "Space", step: "Enter", bounce: 100 };

/** Contact of a switch, and the press that counts: bouncing neither presses nor releases.
 *
 * The first edge counts at once, so that STOP never waits. For the bounce time after it no other
 * does; then the position of the contact counts. */
export interface Contact {
  readonly closed: boolean;
  /** True if it had been open for the bounce time before it closed: else it may repeat a press that goes on,
   * for remote desktops and some interfaces release the key before each repeat. */
  readonly fresh: boolean;
  /** Time of the contact's newest edge, ms. */
  readonly moved: number;
  readonly down: boolean;
  /** Time of the newest edge that counts, ms. */
  readonly counted: number;
}

export const OPEN: Contact = { closed: false, fresh: true, moved: -Infinity, down: false, counted: -Infinity };

export function closing(was: Contact, now: number, bounce: number): Contact {
  const unseen = was.closed && now - was.counted >= bounce; // its opening, as by another window
  const before = unseen ? OPEN : was;
  const fresh = before.closed ? before.fresh : now - before.moved >= bounce;
  return settled({ ...before, closed: true, fresh, moved: now }, now, bounce);
}

export function opening(was: Contact, now: number, bounce: number): Contact {
  return was.closed ? settled({ ...was, closed: false, moved: now }, now, bounce) : was;
}

/** Time goes by. */
export function settled(was: Contact, now: number, bounce: number): Contact {
  if (was.closed === was.down || now - was.counted < bounce) return was;
  return { ...was, down: was.closed, counted: was.moved };
}

export type Direction = "forward" | "left" | "right" | "back";

/** Deflection of each direction (assumed), and the longest time that one press
 * drives it, ms (assumed): somebody who cannot press any more does not drive on. */
export const PUSHES: Readonly<Record<Direction, { at: Deflection; longest: number }>> = {
  forward: { at: { forward: 0.6, left: 0 }, longest: 15_000 },
  left: { at: { forward: 0, left: 0.4 }, longest: 8_000 },
  right: { at: { forward: 0, left: -0.4 }, longest: 8_000 },
  back: { at: { forward: -0.6, left: 0 }, longest: 6_000 },
};

/** A direction that a switch drives, and since when, ms. */
export interface Push {
  readonly direction: Direction;
  readonly since: number;
}

export function pushed(push: Push | null, now: number): Deflection {
  return push && !isOver(push, now) ? PUSHES[push.direction].at : CENTRE;
}

export function isOver(push: Push, now: number): boolean {
  return now - push.since >= PUSHES[push.direction].longest;
}

/** Below these the chair counts as standing, m/s and rad/s. */
const STANDING = 0.03;
const NOT_TURNING = 0.05;

export function isMoving(state: Pick<ChairState, "speed" | "turn_rate"> | null): boolean {
  return state !== null && (Math.abs(state.speed) > STANDING || Math.abs(state.turn_rate) > NOT_TURNING);
}

/** True if the chair drives by itself, now or as soon as the route is free. */
export function isFollowing(state: ChairState | null): boolean {
  return (
    state !== null &&
    state.link === "ready" &&
    (state.mode === "shared" || state.mode === "autonomous") &&
    Boolean(state.goal) &&
    !state.arrived &&
    !state.paused
  );
}

/** Meaning of a switch press in the current state.
 *
 * While the chair moves, or may set off by itself, a press never chooses. Where only the switch
 * moves it, letting go is enough: it stands, and the next choice needs no confirming. */
export function meaning(
  state: ChairState | null,
  push: Push | null,
  driving: boolean,
): "choose" | "let-go" | "stop" {
  if (driving && isFollowing(state)) return "stop";
  if (push !== null) return "let-go";
  return isMoving(state) ? "stop" : "choose";
}

const KEPT = "cohelm.switches";
/** These never become a switch's: they stop, move the focus or change other keys. */
const RESERVED = /^(Escape|Tab|(Shift|Control|Alt|Meta)(Left|Right))$/;

export function mayBeSwitch(code: string): boolean {
  return code !== "" && !RESERVED.test(code);
}

export function keptSwitches(
  storage: () => Pick<Storage, "getItem"> = () => localStorage,
): SwitchSettings {
  try {
    const kept = JSON.parse(storage().getItem(KEPT) ?? "{}") as Record<string, unknown>;
    const key = (x: unknown, otherwise: string) =>
      typeof x === "string" && mayBeSwitch(x) ? x : otherwise;
    const bounce = typeof kept["bounce"] === "number" ? kept["bounce"] : NaN;
    return {
      count: kept["count"] === 1 || kept["count"] === 2 ? kept["count"] : 0,
      hold: kept["hold"] === true,
      choose: key(kept["choose"], NO_SWITCH.choose),
      step: key(kept["step"], NO_SWITCH.step),
      bounce: Number.isFinite(bounce) ? Math.min(Math.max(bounce, 0), MAX_BOUNCE) : NO_SWITCH.bounce,
    };
  } catch {
    return NO_SWITCH;
  }
}

export function keepSwitches(
  settings: SwitchSettings,
  storage: () => Pick<Storage, "setItem"> = () => localStorage,
): void {
  try {
    storage().setItem(KEPT, JSON.stringify(settings));
  } catch {
    // A browser that keeps nothing: they hold until the page is closed.
  }
}

/** A key's name as it stands on it, more or less. */
export function keyName(code: string): string {
  return code.replace(/^(Key|Digit)/, "").replace(/([a-z])([A-Z0-9])/g, "$1 $2");
}
