// Which places on the way the chair has passed: they are neither named nor planned again.

import { chair } from "./chair.svelte";
import { distance, distanceToLine, lastOf } from "./map/strokes";
import type { ActiveWish, ChairState } from "./messages";
import type { Point } from "./map/view";

/** A place counts as passed within this, m (assumed): a chair's length, as it counts as visited. */
const NEAR = 1;
/** What is left of the route stays so much farther from it than the whole, m (assumed). */
const BEHIND = 1;

/** True if a place on the way lies behind the chair; where the route cannot reach it, its nearest point does. */
export function isBehind(at: Point, pose: ChairState["pose"], route: readonly Point[], left: number): boolean {
  if (distance(at, [pose[0], pose[1]]) < NEAR) return true;
  const whole = distanceToLine(at, route);
  return Number.isFinite(whole) && distanceToLine(at, lastOf(route, left)) > whole + BEHIND;
}

type Wish = Pick<ActiveWish, "kind" | "points">;

class Passed {
  #places = $state.raw<readonly string[]>([]);
  #goal: ChairState["goal"] = null;

  /** True if a wish to go via a place is fulfilled. */
  has({ kind, points }: Wish): boolean {
    return kind === "attract" && this.#places.includes(String(points));
  }

  /** Called ten times a second. A new route begins at the chair, so what was passed is remembered. */
  look(): void {
    const { state, route } = chair;
    const { goal } = chair;
    if (goal?.x !== this.#goal?.x || goal?.y !== this.#goal?.y) {
      this.#goal = goal;
      this.#places = [];
    }
    // A route of another version is not the one that `remaining` counts on.
    if (!state || !goal || state.remaining === null || state.route_version !== route.version) return;
    for (const wish of route.wishes) {
      const at = wish.points[0];
      if (wish.kind !== "attract" || !at || this.has(wish)) continue;
      if (isBehind(at, state.pose, route.points, state.remaining)) this.#places = [...this.#places, String(wish.points)];
    }
  }
}

export const passed = new Passed();
