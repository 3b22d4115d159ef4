// Outlines of the walls in a map image, traced along the edges of its cells.

import { distance, simplified } from "../map/strokes";
import type { Point } from "../map/view";

/** Cells of a map; the first row is the lowest one. */
export interface Mask {
  readonly width: number;
  readonly height: number;
  /** 1: solid. */
  readonly cells: Uint8Array;
}

/** A connected area: its outer edge anticlockwise, its holes clockwise. */
export interface Region {
  readonly outer: readonly Point[];
  readonly holes: readonly (readonly Point[])[];
}

/** Steps of the four directions: +x, +y, −x, −y. */
const STEPS = [[1, 0], [0, 1], [-1, 0], [0, -1]] as const;
/** Slanted walls are stairs of cells, whose corners lie up to one cell from a line along the outer
 * ones; a line this near to all of them replaces them, cells. */
const TOLERANCE = 1.01;
/** Round columns keep more of their corners: what is smaller than SMALL cells (assumed). */
const SMALL = 150;
const SMALL_TOLERANCE = 0.75;

/** Solid cells of grey pixels (RGBA, first row at the top): 0 is a wall, 128 unknown, 255 free. */
export function maskOf(pixels: Uint8ClampedArray, width: number, height: number): Mask {
  const cells = new Uint8Array(width * height);
  for (let row = 0; row < height; row++) {
    const from = (height - 1 - row) * width;
    for (let k = 0; k < width; k++) cells[row * width + k] = pixels[4 * (from + k)]! < 64 ? 1 : 0;
  }
  return { width, height, cells };
}

/** The mask without the cells whose centres lie in one of the polygons, given in cells. */
export function without(mask: Mask, polygons: readonly (readonly Point[])[]): Mask {
  const cells = mask.cells.slice();
  for (const polygon of polygons) {
    const xs = polygon.map(([x]) => x);
    const ys = polygon.map(([, y]) => y);
    const [left, right] = [Math.max(0, Math.floor(Math.min(...xs))), Math.min(mask.width, Math.ceil(Math.max(...xs)))];
    const [low, high] = [Math.max(0, Math.floor(Math.min(...ys))), Math.min(mask.height, Math.ceil(Math.max(...ys)))];
    for (let row = low; row < high; row++)
      for (let k = left; k < right; k++)
        if (isInside([k + 0.5, row + 0.5], polygon)) cells[row * mask.width + k] = 0;
  }
  return { ...mask, cells };
}

/** Connected areas of solid cells, in cells; cells that touch at a corner only are not connected. */
export function regionsOf(mask: Mask): Region[] {
  const loops = loopsOf(mask).map(closedSimplified);
  const outers = loops.filter((loop) => areaOf(loop) > 0).map((outer) => ({ outer, holes: [] as Point[][] }));
  const bySize = [...outers].sort((a, b) => areaOf(a.outer) - areaOf(b.outer));
  for (const hole of loops.filter((loop) => areaOf(loop) < 0)) {
    // A corner of a hole may lie on the outer edge; a point just beside its first edge does not.
    const at = besideEdge(hole);
    bySize.find(({ outer }) => isInside(at, outer))?.holes.push(hole);
  }
  return outers;
}

/** Area of a polygon, positive where it is anticlockwise (Gauss's formula). */
export function areaOf(polygon: readonly Point[]): number {
  let sum = 0;
  for (let k = 0; k < polygon.length; k++) {
    const a = polygon[k]!;
    const b = polygon[(k + 1) % polygon.length]!;
    sum += a[0] * b[1] - b[0] * a[1];
  }
  return sum / 2;
}

export function isInside([x, y]: Point, polygon: readonly Point[]): boolean {
  let inside = false;
  for (let k = 0; k < polygon.length; k++) {
    const a = polygon[k]!;
    const b = polygon[(k + 1) % polygon.length]!;
    if (a[1] > y !== b[1] > y && x < a[0] + ((y - a[1]) / (b[1] - a[1])) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

/** Closed lines between solid and free, with the solid on their left; corners only. */
function loopsOf(mask: Mask): Point[][] {
  const wide = mask.width + 1;
  const leaving = edgesOf(mask);
  const loops: Point[][] = [];
  for (let at = 0; at < leaving.length; at++) {
    while (leaving[at]) loops.push(traced(leaving, at, wide));
  }
  return loops;
}

/** For each corner of cells one bit for every direction in which an edge leaves it. */
function edgesOf({ width, height, cells }: Mask): Uint8Array {
  const wide = width + 1;
  const leaving = new Uint8Array(wide * (height + 1));
  const solid = (k: number, row: number): boolean =>
    k >= 0 && row >= 0 && k < width && row < height && cells[row * width + k] === 1;
  for (let row = 0; row < height; row++) {
    for (let k = 0; k < width; k++) {
      if (!solid(k, row)) continue;
      if (!solid(k, row - 1)) leaving[row * wide + k]! |= 1;
      if (!solid(k + 1, row)) leaving[row * wide + k + 1]! |= 2;
      if (!solid(k, row + 1)) leaving[(row + 1) * wide + k + 1]! |= 4;
      if (!solid(k - 1, row)) leaving[(row + 1) * wide + k]! |= 8;
    }
  }
  return leaving;
}

/** One loop from a corner on; its edges are taken from `leaving`. */
function traced(leaving: Uint8Array, start: number, wide: number): Point[] {
  const loop: Point[] = [];
  let at = start;
  let way = Math.log2(leaving[at]! & -leaving[at]!);
  let came = -1;
  do {
    if (way !== came) loop.push([at % wide, Math.floor(at / wide)]);
    leaving[at]! &= ~(1 << way);
    at += STEPS[way]![0] + wide * STEPS[way]![1];
    came = way;
    // To the left first: of two cells that touch at a corner each keeps its own edge.
    const next = [way + 1, way, way + 3].map((each) => each % 4).find((each) => leaving[at]! & (1 << each));
    way = next ?? way;
  } while (at !== start);
  return loop;
}

function closedSimplified(loop: readonly Point[]): Point[] {
  const tolerance = Math.abs(areaOf(loop)) < SMALL ? SMALL_TOLERANCE : TOLERANCE;
  const first = loop[0]!;
  let far = 0;
  loop.forEach((point, k) => {
    if (distance(point, first) > distance(loop[far]!, first)) far = k;
  });
  const there = simplified(loop.slice(0, far + 1), tolerance);
  const back = simplified([...loop.slice(far), first], tolerance);
  const found = [...there.slice(0, -1), ...back.slice(0, -1)];
  // What is a cell or two in size would lose its area.
  const kept = found.length > 2 && areaOf(found) / areaOf(loop) > 0.7;
  return kept ? found : [...loop];
}

function besideEdge(loop: readonly Point[]): Point {
  const [a, b] = [loop[0]!, loop[1]!];
  const length = distance(a, b);
  const aside = 0.01 / length;
  return [(a[0] + b[0]) / 2 - aside * (b[1] - a[1]), (a[1] + b[1]) / 2 + aside * (b[0] - a[0])];
}
