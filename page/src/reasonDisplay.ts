// One reason at a time: reasons change twenty times a second; people read and listen more slowly.

import type { ChairState, ReasonText } from "./messages";

/** Importance of a reason, and what it claims; unlisted ones are faults. */
export type Claim = "fault" | "ask" | "stop" | "slow";

/** STOP, by who pressed it. */
export const STOPS: ReadonlySet<string> = new Set(["rider_stop", "therapist_stop", "stop_pressed"]);
const ASK = new Set([
  ...STOPS, "confirm", "release_stick", "no_driver", "stick_back", "ask_rider", "stick_stuck", "lost", "starting", "paused",
]);
const STOP = new Set(["blocked", "keepout", "edge_ahead", "waiting", "goal_occupied", "replanning", "no_safe_plan", "solver_failed", "navigator_timeout", "late"]);
const SLOW = new Set([
  "too_close", "over_limits", "creeping", "floor_unseen", "edges_allowed", "backing_up", "reversing", "scan_partly_blind", "pose_doubtful", "drive_weak",
]);
/** Motions that the rider notices whatever the speed is. */
const NOTICED = new Set(["backing_up", "reversing"]);
/** Told by the button that asks for it, and by the top line. */
export const ASKED: ReadonlySet<string> = new Set(["confirm", "release_stick", "no_driver"]);
const RANK: Readonly<Record<Claim, number>> = { fault: 3, ask: 2, stop: 1, slow: 0 };

/** A sentence stays to be read at least this long, ms (assumed). */
export const READ = 1_000;
/** A reason must last so long before it is shown, ms (assumed): a shorter one is not felt. */
const LASTS: Readonly<Record<Claim, number>> = { fault: 0, ask: 0, stop: 400, slow: 600 };
/** A reason that is gone for less than this is not gone, ms (assumed). */
const GAP = 400;
/** It is spoken once it has been shown this long, ms (assumed). */
const SPOKEN = 700;
/** Minimum time before the same sentence is spoken again, ms (assumed). */
const AGAIN = 15_000;
/** From this speed on the chair drives, whatever a reason says, m/s. */
const DRIVES = 0.08;
/** A slow-down is felt below this share of the speed of the last seconds (assumed). */
const FELT = 0.7;
/** Time constant with which that speed is forgotten, ms. */
const FORGETS = 5_000;

/** Reason on display, and the sentence for screen readers. */
export interface ReasonDisplay {
  readonly shown: ReasonText | null;
  readonly since: number;
  /** When a reason with the shown code was last true, ms. */
  readonly trueAt: number;
  /** Content of the live region; empty when no reason is shown. */
  readonly spoken: string;
  readonly last: string;
  readonly lastAt: number;
  /** The reason that may be shown next, and since when it holds, ms. */
  readonly next: ReasonText | null;
  readonly nextSince: number;
  readonly nextAt: number;
  /** Speed of the last seconds, m/s. */
  readonly pace: number;
  readonly at: number;
}

export const SILENT: ReasonDisplay = {
  shown: null, since: -Infinity, trueAt: -Infinity, spoken: "", last: "", lastAt: -Infinity,
  next: null, nextSince: 0, nextAt: -Infinity, pace: 0, at: 0,
};

export type Seen = Pick<ChairState, "speed" | "reason" | "command">;

export function claimOf(code: string): Claim {
  if (ASK.has(code)) return "ask";
  if (STOP.has(code)) return "stop";
  return SLOW.has(code) ? "slow" : "fault";
}

/** Trouble of health or input that asks the rider for something. */
const HOLDS = new Set(["lost", "stick_stuck", "stick_back"]);
const NO_FAULT = new Set(["", "arrived"]);

/** True if a fault holds the chair: the reason on display is one, or "Go on" could not end the stop. */
export function holdsTrip(code: string, notReady: ReasonText | null): boolean {
  return notReady !== null || HOLDS.has(code) || (!NO_FAULT.has(code) && claimOf(code) === "fault");
}

/** The reason of a state, where it is true of what the chair does and is felt. */
export function felt({ speed, reason, command }: Seen, pace: number): ReasonText | null {
  if (!reason) return null;
  const claim = claimOf(reason.code);
  const drives = Math.abs(speed) >= DRIVES || Math.abs(command[0]) >= DRIVES;
  if (claim === "stop") return drives ? null : reason;
  // "Driving slowly" is not true of a chair that stands.
  if (claim === "slow" && !NOTICED.has(reason.code) && !drives) return null;
  if (claim === "slow") return NOTICED.has(reason.code) || Math.abs(speed) < FELT * pace ? reason : null;
  return reason;
}

/** The display after one more state; null: no state comes. */
export function told(was: ReasonDisplay, state: Seen | null, now: number): ReasonDisplay {
  const speed = Math.abs(state?.speed ?? 0);
  const kept = was.pace * Math.exp(-Math.max(0, now - was.at) / FORGETS);
  const pace = Math.max(speed, kept);
  const why = state ? felt(state, pace) : null;
  const lasting = waiting({ ...was, pace, at: now }, why, now);
  return spoken(changed(lasting, why, now), now);
}

/** Since when the newest reason holds, short gaps left out. */
function waiting(was: ReasonDisplay, why: ReasonText | null, now: number): ReasonDisplay {
  if (!why) return now - was.nextAt > GAP ? { ...was, next: null } : was;
  const same = was.next?.code === why.code && now - was.nextAt <= GAP;
  const more = was.next && !same && rank(was.next) > rank(why) && now - was.nextAt <= GAP;
  if (more) return was;
  return { ...was, next: why, nextSince: same ? was.nextSince : now, nextAt: now };
}

function changed(was: ReasonDisplay, why: ReasonText | null, now: number): ReasonDisplay {
  const { shown, next } = was;
  if (shown && why?.code === shown.code) {
    const reworded = why.text !== shown.text;
    return reworded ? { ...was, shown: why, trueAt: now, spoken: "" } : { ...was, trueAt: now };
  }
  const read = !shown || now - was.since >= READ;
  const due = next && next.code !== shown?.code && was.nextAt - was.nextSince >= LASTS[claimOf(next.code)];
  if (next && due && (read || (shown && rank(next) > rank(shown)))) {
    return { ...was, shown: next, since: now, trueAt: now, spoken: "" };
  }
  // A stop whose reason changes has no gap between the two: nothing sets off there.
  const follows = next !== null && next.code !== shown?.code && now - was.nextAt <= GAP;
  const gone = shown && read && now - was.trueAt > (follows ? GAP + LASTS.slow : GAP);
  return gone ? { ...was, shown: null, since: now, spoken: "" } : was;
}

function rank(reason: ReasonText): number {
  return RANK[claimOf(reason.code)];
}

function spoken(saying: ReasonDisplay, now: number): ReasonDisplay {
  const { shown, since, last, lastAt } = saying;
  if (!shown || saying.spoken === shown.text || now - since < SPOKEN) return saying;
  if (shown.text === last && now - lastAt < AGAIN) return saying;
  return { ...saying, spoken: shown.text, last: shown.text, lastAt: now };
}
