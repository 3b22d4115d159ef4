// Flat ribbons on the floor along a line.

import type { Point } from "../map/view";
import { distance, lengthOf } from "../map/strokes";

/** Vertices (x, y, z, …), m, and triangles. */
export interface Strip {
  readonly positions: number[];
  readonly indices: number[];
}

/** A mitre at a sharp corner is no longer than this many half widths. */
const LONGEST_MITRE = 2.5;
/** Two points nearer than this are one, m. */
const SAME = 1e-3;

/** Two vertices for each point of the line: left of it, then right of it; triangles face up. */
export function ribbon(line: readonly Point[], width: number, z: number): Strip {
  const points = line.filter((point, k) => k === 0 || distance(point, line[k - 1]!) > SAME);
  const positions: number[] = [];
  const indices: number[] = [];
  if (points.length < 2) return { positions, indices };
  points.forEach((point, k) => {
    const [nx, ny] = mitre(points, k);
    positions.push(point[0] + (nx * width) / 2, point[1] + (ny * width) / 2, z);
    positions.push(point[0] - (nx * width) / 2, point[1] - (ny * width) / 2, z);
    if (k === 0) return;
    const [left, right] = [2 * k - 2, 2 * k - 1];
    indices.push(left, right, left + 2, right, right + 2, left + 2);
  });
  return { positions, indices };
}

/** Ribbons of `on` m with `off` m between them. */
export function dashes(line: readonly Point[], width: number, z: number, on: number, off: number): Strip {
  const whole: { positions: number[]; indices: number[] } = { positions: [], indices: [] };
  const length = lengthOf(line);
  for (let from = 0; from < length; from += on + off) {
    const dash = ribbon(cut(line, from, Math.min(length, from + on)), width, z);
    const first = whole.positions.length / 3;
    whole.positions.push(...dash.positions);
    whole.indices.push(...dash.indices.map((index) => first + index));
  }
  return whole;
}

/** The part of a line between two distances from its beginning, m. */
export function cut(line: readonly Point[], from: number, to: number): Point[] {
  const part: Point[] = [];
  let driven = 0;
  for (let k = 1; k < line.length; k++) {
    const [a, b] = [line[k - 1]!, line[k]!];
    const step = distance(a, b);
    if (step === 0) continue;
    const on = (s: number): Point => [a[0] + (s / step) * (b[0] - a[0]), a[1] + (s / step) * (b[1] - a[1])];
    const [begin, end] = [Math.max(0, from - driven), Math.min(step, to - driven)];
    if (begin < end) {
      if (part.length === 0) part.push(on(begin));
      part.push(on(end));
    }
    driven += step;
  }
  return part;
}

/** Left of the line at a point, as long as its edges' offsets meet, in half widths. */
function mitre(line: readonly Point[], k: number): Point {
  const before = normal(line[Math.max(0, k - 1)]!, line[Math.max(1, k)]!);
  const after = normal(line[Math.min(line.length - 2, k)]!, line[Math.min(line.length - 1, k + 1)]!);
  const sum: Point = [before[0] + after[0], before[1] + after[1]];
  const length = Math.hypot(...sum);
  if (length < 1e-6) return after;
  // Half the angle's cosine is |sum| / 2; the mitre is its inverse.
  const size = Math.min(2 / length, LONGEST_MITRE) / length;
  return [sum[0] * size, sum[1] * size];
}

function normal(a: Point, b: Point): Point {
  const length = distance(a, b) || 1;
  return [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
}
