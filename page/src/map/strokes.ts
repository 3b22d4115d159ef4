// Drawn lines converted to route preferences.

import type { Point } from "./view";

/** The longest line that a wish may have. */
export const MOST_POINTS = 60;

/** Without the points that are nearer than `tolerance` to the line of the others (Ramer 1972). */
export function simplified(line: readonly Point[], tolerance: number): Point[] {
  if (line.length < 3) return [...line];
  const first = line[0]!;
  const last = line[line.length - 1]!;
  let worst = 0;
  let farthest = 0;
  for (let k = 1; k < line.length - 1; k++) {
    const d = distanceToSegment(line[k]!, first, last);
    if (d > farthest) [worst, farthest] = [k, d];
  }
  if (farthest <= tolerance) return [first, last];
  const head = simplified(line.slice(0, worst + 1), tolerance);
  return [...head.slice(0, -1), ...simplified(line.slice(worst), tolerance)];
}

/** As few points as a message may carry. */
export function drawn(line: readonly Point[], tolerance = 0.1): Point[] {
  let points = simplified(line, tolerance);
  for (let t = 2 * tolerance; points.length > MOST_POINTS; t *= 2) points = simplified(line, t);
  return points;
}

export function lengthOf(line: readonly Point[]): number {
  let sum = 0;
  for (let k = 1; k < line.length; k++) sum += distance(line[k]!, line[k - 1]!);
  return sum;
}

/** Length of a line up to its point that is nearest to `p`, m. */
export function lengthTo(line: readonly Point[], p: Point): number {
  let [nearest, to, before] = [Infinity, 0, 0];
  for (let k = 1; k < line.length; k++) {
    const [a, b] = [line[k - 1]!, line[k]!];
    const d = distanceToSegment(p, a, b);
    if (d < nearest) [nearest, to] = [d, before + shareAlong(p, a, b) * distance(a, b)];
    before += distance(a, b);
  }
  return to;
}

/** The end of a line that is `length` long, m; all of it where it is shorter. */
export function lastOf(line: readonly Point[], length: number): Point[] {
  const end: Point[] = [];
  let left = length;
  for (let k = line.length - 1; k >= 0; k--) {
    const point = line[k]!;
    const next = line[k + 1];
    const step = next ? distance(point, next) : 0;
    if (next && left <= 0) break;
    if (next && step > left) {
      const share = left / step;
      return [[next[0] + share * (point[0] - next[0]), next[1] + share * (point[1] - next[1])], ...end];
    }
    left -= step;
    end.unshift(point);
  }
  return end;
}

/** The zone that a drawn line keeps free: what it encloses, or a band about it.
 *
 * Three points and more are an outline to the chair, so an open line becomes the outline of its
 * band. Returns the points and how far the zone reaches beyond them, m. */
export function zoneOf(line: readonly Point[], aside = 0.4): { points: Point[]; radius: number } {
  const points = drawn(line, 0.15);
  const first = points[0]!;
  const last = points[points.length - 1]!;
  if (points.length < 3) return { points, radius: aside };
  const closed = distance(first, last) < 0.25 * lengthOf(points);
  if (closed) return { points, radius: 0 };
  const half = Math.floor(MOST_POINTS / 2);
  const spine = points.length > half ? drawn(line, 0.3).slice(0, half) : points;
  const left = spine.map((_, k) => besides(spine, k, aside));
  const right = spine.map((_, k) => besides(spine, k, -aside)).reverse();
  return { points: [...left, ...right], radius: 0 };
}

function besides(line: readonly Point[], k: number, aside: number): Point {
  const a = line[Math.max(0, k - 1)]!;
  const b = line[Math.min(line.length - 1, k + 1)]!;
  const p = line[k]!;
  const length = distance(a, b) || 1;
  return [p[0] - (aside * (b[1] - a[1])) / length, p[1] + (aside * (b[0] - a[0])) / length];
}

export function distance(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

export function distanceToSegment(p: Point, a: Point, b: Point): number {
  const t = shareAlong(p, a, b);
  return distance(p, [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
}

/** Where on a segment the point nearest to `p` lies, 0…1. */
function shareAlong(p: Point, a: Point, b: Point): number {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const square = dx * dx + dy * dy;
  const along = square > 0 ? ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square : 0;
  return Math.min(1, Math.max(0, along));
}

/** The middle of where one line is far from the other: a detour shows best there. */
export function farthestFrom(line: readonly Point[], other: readonly Point[]): Point | null {
  if (other.length < 2) return null;
  const points = sampled(line, 0.5);
  const apart = points.map((p) => distanceToLine(p, other));
  const most = Math.max(...apart);
  if (most < 0.5) return null;
  const far = points.filter((_, k) => apart[k]! > 0.8 * most);
  return far[Math.floor(far.length / 2)] ?? null;
}

/** Points on a line, no farther from each other than `step`. */
function sampled(line: readonly Point[], step: number): Point[] {
  return line.flatMap((b, k) => {
    const a = line[Math.max(0, k - 1)]!;
    const n = Math.max(1, Math.ceil(distance(a, b) / step));
    const share = (i: number): number => (i + 1) / n;
    return Array.from({ length: n }, (_, i): Point => [
      a[0] + share(i) * (b[0] - a[0]),
      a[1] + share(i) * (b[1] - a[1]),
    ]);
  });
}

export function distanceToLine(p: Point, line: readonly Point[]): number {
  let nearest = Infinity;
  for (let k = 1; k < line.length; k++) {
    nearest = Math.min(nearest, distanceToSegment(p, line[k - 1]!, line[k]!));
  }
  return nearest;
}

/** True if a point lies within an outline (even-odd rule). */
export function contains(outline: readonly Point[], [x, y]: Point): boolean {
  let inside = false;
  outline.forEach((a, k) => {
    const b = outline[(k + 1) % outline.length]!;
    if (a[1] > y !== b[1] > y && x < a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) inside = !inside;
  });
  return inside;
}

/** Area of an outline, m². */
export function areaOf(outline: readonly Point[]): number {
  const twice = outline.reduce((sum, a, k) => {
    const b = outline[(k + 1) % outline.length]!;
    return sum + a[0] * b[1] - a[1] * b[0];
  }, 0);
  return Math.abs(twice) / 2;
}
