// How much of the present motion is the rider's.

import { isMoving } from "./input/switches";
import type { ChairState } from "./messages";

export type Steerer = "you" | "both" | "chair";

/** Below this share the chair steers alone, above one less this the rider does. */
const ALONE = 0.15;

/** The rider's share of the motion, 0…1; null: nothing moves. */
export function shareOf(state: Pick<ChairState, "speed" | "turn_rate" | "rider_authority"> | null): number | null {
  return state && isMoving(state) ? state.rider_authority : null;
}

export function steererOf(share: number): Steerer {
  if (share < ALONE) return "chair";
  return share > 1 - ALONE ? "you" : "both";
}
