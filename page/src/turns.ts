// The next turn of a route, from its points; what a passenger would be told.

import { lastOf, distance } from "./map/strokes";
import type { Point } from "./map/view";

export interface Turn {
  readonly side: "left" | "right";
  /** Way to it, m. */
  readonly after: number;
  readonly at: Point;
}

/** Distance over which a direction is measured, m: shorter ones follow the wiggles of the line. */
const ARM = 1.5;
const STEP = 0.25;
/** Smallest change of direction that is called a turn, rad: 40 degrees. */
const TURN = (40 * Math.PI) / 180;
/** Cosine of the angle between heading and way from which on a chair has its back to it: 120 degrees (assumed). */
const AWAY = Math.cos((120 * Math.PI) / 180);

/** The first turn ahead; null: straight on to the end.
 *
 * points: of the whole route.  left: what is left of it, m. */
export function nextTurn(points: readonly Point[], left: number): Turn | null {
  const line = evenly(lastOf(points, left), STEP);
  const arm = Math.round(ARM / STEP);
  let best: { k: number; by: number } | null = null;
  for (let k = arm; k + arm < line.length; k++) {
    const by = turned(line[k - arm]!, line[k]!, line[k + arm]!);
    if (best && (Math.abs(by) < TURN || Math.sign(by) !== Math.sign(best.by))) break;
    if (Math.abs(by) >= TURN && (!best || Math.abs(by) > Math.abs(best.by))) best = { k, by };
  }
  if (!best) return null;
  return { side: best.by > 0 ? "left" : "right", after: best.k * STEP, at: line[best.k]! };
}

/** True if a chair of that heading, rad, has its back to the way that is left. */
export function facesAway(points: readonly Point[], left: number, heading: number): boolean {
  const line = evenly(lastOf(points, left), STEP);
  const [a, b] = [line[0], line[Math.round(ARM / STEP)]];
  if (!a || !b) return false;
  const by = Math.atan2(b[1] - a[1], b[0] - a[0]) - heading;
  return Math.cos(by) < AWAY;
}

/** Change of direction from a to b to c, counter-clockwise, rad. */
function turned(a: Point, b: Point, c: Point): number {
  const by = Math.atan2(c[1] - b[1], c[0] - b[0]) - Math.atan2(b[1] - a[1], b[0] - a[0]);
  return Math.atan2(Math.sin(by), Math.cos(by));
}

function evenly(line: readonly Point[], step: number): Point[] {
  const points: Point[] = line[0] ? [line[0]] : [];
  let due = step;
  for (let k = 1; k < line.length; k++) {
    const [a, b] = [line[k - 1]!, line[k]!];
    const length = distance(a, b);
    let along = due;
    for (; along <= length; along += step) {
      const share = along / length;
      points.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]);
    }
    due = along - length;
  }
  return points;
}
