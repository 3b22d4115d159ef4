// Why a driving chair is slow, although no reason is told: the planner slows down by itself.

import type { Cause } from "./around";
import { distance } from "./map/strokes";
import type { ChairState } from "./messages";

/** Speeds of the paces, m/s, before limits; the same as the chair's own. */
export const SPEED = { slow: 0.4, normal: 0.7, brisk: 1.0 } as const;

/** Below this share of its pace a chair is slow (assumed). */
const SLOW = 0.5;
/** It drives from this speed on, m/s. */
const DRIVES = 0.05;
/** A chair that turns faster is slow for the turn, rad/s (assumed). */
const TURNS = 0.3;
/** A turn within this is near, m (assumed). */
const SOON = 1.5;
/** With more of the motion the rider is who drives slowly (assumed). */
const RIDERS = 0.2;
/** Nearer to its destination a chair is slow for that, m (assumed). */
const ARRIVES = 2;
/** The person is no farther than this, m (assumed). */
const NEAR = 2.5;

/** What a chair without a reason is slow for. */
export type Slowness = "person" | "turn" | "destination" | "narrow";

type Moving = Pick<ChairState, "pose" | "goal" | "remaining" | "speed" | "turn_rate" | "pace" | "rider_authority">;

/** True if a chair on a trip drives below a share of its pace, and not by its rider's hand. */
export function isSlow(state: Moving, maxSpeed: number, share = SLOW): boolean {
  if (!state.goal || state.rider_authority > RIDERS) return false;
  return state.speed >= DRIVES && state.speed <= share * paceOf(state.pace, maxSpeed);
}

/**
 * What a chair that drives below half its pace on a trip is slow for; null: it is not, or nobody knows.
 *
 * turn: way to the next turn, m; null: there is none, or it does not matter.
 */
export function slowFor(
  state: Moving, cause: Cause | null, maxSpeed: number, turn: number | null = null, share = SLOW,
): Slowness | null {
  if (!isSlow(state, maxSpeed, share)) return null;
  if ((state.remaining ?? 0) < ARRIVES) return "destination";
  if (Math.abs(state.turn_rate) > TURNS || (turn !== null && turn < SOON)) return "turn";
  if (!cause || distance(cause.at, [state.pose[0], state.pose[1]]) >= NEAR) return null;
  return cause.thing === "person" ? "person" : "narrow";
}

/** The most that a pace allows, m/s. */
export function paceOf(pace: ChairState["pace"], maxSpeed: number): number {
  return Math.min(SPEED[pace], maxSpeed);
}
