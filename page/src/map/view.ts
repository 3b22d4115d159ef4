// Transform from map to screen. The map is in metres, y up (REP-103); the screen in CSS
// pixels, y down.

export type Point = readonly [x: number, y: number];

export interface View {
  /** The map's point that lies at `middle`, m. */
  readonly at: Point;
  /** Its position on the screen, px. */
  readonly middle: Point;
  /** Pixels a metre. */
  readonly scale: number;
  /** By how much the map is turned, counter-clockwise, rad; 0 is north up. */
  readonly turn: number;
}

export interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

export const CLOSEST = 160;
export const FARTHEST = 4;

export function toScreen(view: View, x: number, y: number): Point {
  const dx = x - view.at[0];
  const dy = y - view.at[1];
  const c = Math.cos(view.turn);
  const s = Math.sin(view.turn);
  return [
    view.middle[0] + view.scale * (c * dx - s * dy),
    view.middle[1] - view.scale * (s * dx + c * dy),
  ];
}

export function toMap(view: View, x: number, y: number): Point {
  const u = (x - view.middle[0]) / view.scale;
  const v = (view.middle[1] - y) / view.scale;
  const c = Math.cos(view.turn);
  const s = Math.sin(view.turn);
  return [view.at[0] + c * u + s * v, view.at[1] - s * u + c * v];
}

/** View that moves a map point to a screen position. */
export function pinned(view: View, point: Point, screen: Point): View {
  const [x, y] = toScreen(view, ...point);
  return panned(view, screen[0] - x, screen[1] - y);
}

export function panned(view: View, dx: number, dy: number): View {
  const [x, y] = view.middle;
  return { ...view, at: toMap(view, x - dx, y - dy) };
}

/** Zoomed about a place on the screen, which stays where it is. */
export function zoomed(view: View, factor: number, x: number, y: number): View {
  const point = toMap(view, x, y);
  const scale = Math.min(CLOSEST, Math.max(FARTHEST, view.scale * factor));
  return pinned({ ...view, scale }, point, [x, y]);
}

/** At first: the chair, with some ten metres about it. */
export function begun(pose: readonly [number, number, number], width: number, height: number): View {
  const scale = Math.min(48, Math.max(22, Math.min(width, height) / 16));
  return { at: [pose[0], pose[1]], middle: [width / 2, height / 2], scale, turn: 0 };
}

/** North up, with all of a box of the map on the screen. */
export function fitted(box: Box, width: number, height: number, margin = 16): View {
  const room = (full: number): number => Math.max(40, full - 2 * margin);
  const scale = Math.min(room(width) / Math.max(box.width, 0.1), room(height) / Math.max(box.height, 0.1));
  return {
    at: [box.x + box.width / 2, box.y + box.height / 2],
    middle: [width / 2, height / 2],
    scale: Math.min(CLOSEST, Math.max(1, scale)),
    turn: 0,
  };
}

/** The smallest box about some points; null: there are none. */
export function boxOf(points: readonly Point[]): Box | null {
  if (points.length === 0) return null;
  const xs = points.map(([x]) => x);
  const ys = points.map(([, y]) => y);
  const [x, y] = [Math.min(...xs), Math.min(...ys)];
  return { x, y, width: Math.max(...xs) - x, height: Math.max(...ys) - y };
}

/** North up, moved no more than it takes to have the chair within the middle of the screen. */
export function followed(view: View, x: number, y: number, width: number, height: number): View {
  const north = { ...view, turn: 0, middle: [width / 2, height / 2] as const };
  const [sx, sy] = toScreen(north, x, y);
  const over = (s: number, full: number): number =>
    Math.max(0, s - 0.62 * full) + Math.min(0, s - 0.38 * full);
  return panned(north, -over(sx, width), -over(sy, height));
}

/** Moved so that no more emptiness about a box of the map is seen than must be; north up only. */
export function within(view: View, box: Box, width: number, height: number): View {
  if (view.turn !== 0) return view;
  const [left, bottom] = toScreen(view, box.x, box.y);
  const [right, top] = toScreen(view, box.x + box.width, box.y + box.height);
  return panned(view, inside(left, right, width), inside(top, bottom, height));
}

/** By how much a stretch has to be moved to fill a screen, or to lie in its middle if shorter. */
function inside(from: number, to: number, full: number): number {
  if (to - from <= full) return (full - from - to) / 2;
  return Math.min(0, -from) || Math.max(0, full - to);
}

/** The map turns in steps of this, rad: small ones are not seen, and would cost a redraw each. */
const STEP = 0.01;

/** Room that the chair needs on the screen, from its middle, px. */
const ROOM = 36;

/** The chair in the lower part of the screen, its heading up.
 *
 * height: of what no card or sheet covers.  top: of what messages cover; the chair stays below it. */
export function headed(
  view: View,
  pose: readonly [number, number, number],
  width: number,
  height: number,
  top = 0,
): View {
  const y = Math.min(height - ROOM, Math.max(0.7 * height, top + ROOM));
  return {
    ...view,
    at: [pose[0], pose[1]],
    middle: [width / 2, y],
    turn: STEP * Math.round((Math.PI / 2 - pose[2]) / STEP),
  };
}
