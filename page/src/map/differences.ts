// Where the building differs from the map: cells with a question mark.

import type { MapDifference } from "../messages";
import { badge } from "./badge";
import type { Colours } from "./palette";
import { toScreen, type Point, type View } from "./view";

/** Nearer than this a place has its mark, pixels a metre. */
const MARKED = 9;

export function drawDifferences(
  context: CanvasRenderingContext2D,
  found: readonly MapDifference[],
  cell: number,
  colours: Colours,
  view: View,
): void {
  const half = cell / 2;
  for (const { kind, x, y, cells } of found) {
    context.beginPath();
    for (const [cx, cy] of cells) {
      const corners: Point[] = [[-half, -half], [half, -half], [half, half], [-half, half]];
      corners.forEach(([dx, dy], k) => {
        const at = toScreen(view, cx + dx, cy + dy);
        if (k === 0) context.moveTo(...at);
        else context.lineTo(...at);
      });
      context.closePath();
    }
    context.fillStyle = kind === "new" ? colours.wall : colours.free;
    context.globalAlpha = 0.75;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = colours.accent;
    context.lineWidth = 1.5;
    context.setLineDash(kind === "new" ? [] : [3, 3]);
    context.stroke();
    context.setLineDash([]);
    if (view.scale < MARKED) continue;
    const [mx, my] = toScreen(view, x, y);
    badge(context, "?", mx, my - 18, colours.accent, colours.free);
  }
}
