// Who a driving chair is slow for, although no reason is told: the planner slows down by itself.

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
/** With more of the motion the rider is who drives slowly (assumed). */
const RIDERS = 0.2;
/** Nearer to its destination a chair is slow for that, m (assumed). */
const ARRIVES = 2;
/** The person is no farther than this, m (assumed). */
const NEAR = 2.5;

type Moving = Pick<ChairState, "pose" | "goal" | "remaining" | "speed" | "turn_rate" | "pace" | "rider_authority">;

/** True if a chair on a trip drives slowly and a person is the nearest thing ahead. */
export function slowForPerson(state: Moving, cause: Cause | null, maxSpeed: number): boolean {
  if (!state.goal || (state.remaining ?? 0) < ARRIVES || Math.abs(state.turn_rate) > TURNS) return false;
  if (state.rider_authority > RIDERS) return false;
  if (state.speed < DRIVES || state.speed > SLOW * Math.min(SPEED[state.pace], maxSpeed)) return false;
  return cause?.thing === "person" && distance(cause.at, [state.pose[0], state.pose[1]]) < NEAR;
}
