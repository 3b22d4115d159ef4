// Floor behind edges that the chair cannot take: a band with oblique stripes.

import type { EdgeCells, FloorInfo } from "../messages";
import type { Colours } from "./palette";
import { distance } from "./strokes";
import { toScreen, type Box, type Point, type View } from "./view";

/** Side of the tile that the stripes repeat, px. */
const TILE = 12;

/** Runs of cells as boxes of the map, m. */
export function boxesOf(runs: EdgeCells["runs"], { x, y, resolution: side }: FloorInfo): Box[] {
  return runs.map(([row, col, count]) => ({ x: x + col * side, y: y + row * side, width: count * side, height: side }));
}

/** The nearest point behind an edge within a distance, m; one that is ahead before others; null: there is none. */
export function nearestEdge([x, y, heading]: readonly [number, number, number], edges: readonly Box[], within: number): Point | null {
  const found = edges
    .map((box): Point => [clamped(x, box.x, box.width), clamped(y, box.y, box.height)])
    .filter((at) => distance(at, [x, y]) < within)
    .sort((a, b) => distance(a, [x, y]) - distance(b, [x, y]));
  const isAhead = ([px, py]: Point): boolean => (px - x) * Math.cos(heading) + (py - y) * Math.sin(heading) > 0;
  return found.find(isAhead) ?? found[0] ?? null;
}

function clamped(value: number, from: number, length: number): number {
  return Math.min(from + length, Math.max(from, value));
}

/** Stripes on a ground, as a tile that repeats in both directions. */
export function stripes({ warn, warnGround }: Pick<Colours, "warn" | "warnGround">, side: number): HTMLCanvasElement {
  const tile = document.createElement("canvas");
  tile.width = tile.height = side;
  const context = tile.getContext("2d");
  if (!context) return tile;
  context.fillStyle = warnGround;
  context.fillRect(0, 0, side, side);
  context.strokeStyle = warn;
  context.lineWidth = side / 4;
  context.beginPath();
  for (const from of [-side, 0, side]) {
    // Beyond the tile, so that no end of a line shows in a corner.
    context.moveTo(from - side, 2 * side);
    context.lineTo(from + 2 * side, -side);
  }
  context.stroke();
  return tile;
}

export function drawEdges(context: CanvasRenderingContext2D, edges: readonly Box[], colours: Colours, view: View): void {
  if (edges.length === 0) return;
  context.beginPath();
  for (const { x, y, width, height } of edges) {
    context.moveTo(...toScreen(view, x, y));
    context.lineTo(...toScreen(view, x + width, y));
    context.lineTo(...toScreen(view, x + width, y + height));
    context.lineTo(...toScreen(view, x, y + height));
    context.closePath();
  }
  // The fill covers the inner half of the lines, so that only the outline of all cells is seen.
  context.strokeStyle = colours.warn;
  context.lineWidth = 4;
  context.stroke();
  context.fillStyle = context.createPattern(stripes(colours, TILE), "repeat")!;
  context.fill();
}
