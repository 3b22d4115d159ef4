// What the rider chooses on the map: the place of a trip that has not begun, a touched point, a drawn line.

import { chair } from "../chair.svelte";
import { selection } from "../mapSelection.svelte";
import { trip } from "../trip.svelte";
import { pin } from "./figures";
import type { Colours } from "./palette";
import { toScreen, type Point, type View } from "./view";

/** Where a trip that is looked at would lead; null: none is. */
function aim(): Point | null {
  if (!trip.open || !trip.draft) return null;
  const { to } = trip.draft;
  if ("point" in to) return to.point;
  const named = chair.scene?.places.find(({ name }) => name === to.place);
  return named ? [named.x, named.y] : null;
}

export function drawChosen(context: CanvasRenderingContext2D, on: View, of: Colours): void {
  const { line, touched, tool } = selection;
  const to = aim();
  if (to) pin(context, ...toScreen(on, ...to), of.route, of.free);
  if (touched) pin(context, ...toScreen(on, ...touched.point), of.preview, of.free);
  if (!line) return;
  context.strokeStyle = tool === "not-this-way" ? of.unwish : of.wish;
  context.lineWidth = 8;
  context.lineCap = context.lineJoin = "round";
  context.globalAlpha = 0.7;
  context.beginPath();
  for (const point of line) context.lineTo(...toScreen(on, ...point));
  context.stroke();
  context.globalAlpha = 1;
}
