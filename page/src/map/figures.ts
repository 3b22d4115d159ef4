// Moving layer: people in their personal spaces, the plan, the chair.

import type { Cause, Direction } from "../around";
import type { ChairInfo, Destination, PersonInfo, ChairState } from "../messages";
import { traced } from "./backdrop";
import { badge } from "./badge";
import type { Shown } from "./motion";
import type { Colours } from "./palette";
import { toScreen, type Point, type View } from "./view";

/** A body this near to where the chair sees somebody is the same person, m. */
const SEEN = 0.5;

export interface Moving {
  readonly shown: Shown;
  readonly state: ChairState;
  readonly chair: ChairInfo;
  readonly colours: Colours;
  /** Directions about the chair; none: not shown. */
  readonly ring: readonly Direction[];
  /** What the shown reason is about. */
  readonly cause: Cause | null;
}

export function drawFigures(context: CanvasRenderingContext2D, moving: Moving, view: View): void {
  const { shown, state, colours } = moving;
  context.fillStyle = colours.group;
  context.globalAlpha = 0.22;
  for (const outline of state.groups) {
    traced(context, outline, view);
    context.fill();
  }
  drawSpaces(context, shown.people, colours, view);
  drawBodies(context, unseen(shown), colours, view);
  drawPlan(context, state, colours, view);
  for (const person of shown.people) drawPerson(context, person, colours, view);
  drawChair(context, shown, moving, view);
  drawRing(context, shown, moving, view);
  if (moving.cause) drawCause(context, moving.cause, colours, view);
  if (state.goal) drawGoal(context, state.goal, colours, view);
}

/** Where the chair was last seen, once the connection is lost: nothing else is known. */
export function drawLastSeen(
  context: CanvasRenderingContext2D,
  shown: Shown,
  figure: Pick<Moving, "chair" | "colours">,
  view: View,
): void {
  drawChair(context, shown, figure, view);
}

/** Half an ellipse ahead and half a one behind. */
function drawSpaces(
  context: CanvasRenderingContext2D,
  people: readonly PersonInfo[],
  colours: Colours,
  view: View,
): void {
  context.fillStyle = colours.space;
  context.strokeStyle = colours.space;
  context.lineWidth = 1;
  for (const { x, y, axis, front, side, rear } of people) {
    const [sx, sy] = toScreen(view, x, y);
    const ahead = -(axis + view.turn);
    const quarter = Math.PI / 2;
    context.beginPath();
    context.ellipse(sx, sy, front * view.scale, side * view.scale, ahead, -quarter, quarter);
    context.ellipse(sx, sy, rear * view.scale, side * view.scale, ahead, quarter, 3 * quarter);
    context.closePath();
    context.globalAlpha = 0.2;
    context.fill();
    context.globalAlpha = 0.55;
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** Simulated people whom the chair does not detect. */
export function unseen({ true_people, people }: Pick<Shown, "true_people" | "people">): ChairState["true_people"] {
  return true_people.filter(([x, y]) => !people.some((p) => Math.hypot(p.x - x, p.y - y) < SEEN));
}

/** Whom the chair does not see: thin rings. */
function drawBodies(
  context: CanvasRenderingContext2D,
  bodies: ChairState["true_people"],
  colours: Colours,
  view: View,
): void {
  context.strokeStyle = colours.person;
  context.lineWidth = 1.5;
  context.setLineDash([3, 3]);
  context.beginPath();
  for (const [x, y, radius] of bodies) {
    const [sx, sy] = toScreen(view, x, y);
    const r = Math.max(2, radius * view.scale);
    context.moveTo(sx + r, sy);
    context.arc(sx, sy, r, 0, 2 * Math.PI);
  }
  context.stroke();
  context.setLineDash([]);
}

function drawPerson(
  context: CanvasRenderingContext2D,
  person: PersonInfo,
  colours: Colours,
  view: View,
): void {
  const [x, y] = toScreen(view, person.x, person.y);
  const r = Math.max(3, person.radius * view.scale);
  context.fillStyle = colours.person;
  context.beginPath();
  context.arc(x, y, r, 0, 2 * Math.PI);
  if (person.seen === false) {
    // Remembered: a full ring about a pale body.
    context.globalAlpha = 0.3;
    context.fill();
    context.globalAlpha = 1;
    context.strokeStyle = colours.person;
    context.lineWidth = 2;
    context.stroke();
    return;
  }
  context.fill();
  if (Math.hypot(person.vx, person.vy) < 0.15) return;
  const ahead = -(Math.atan2(person.vy, person.vx) + view.turn);
  context.save();
  context.translate(x, y);
  context.rotate(ahead);
  context.fillStyle = colours.free;
  context.beginPath();
  context.moveTo(0.75 * r, 0);
  context.lineTo(-0.25 * r, 0.5 * r);
  context.lineTo(-0.25 * r, -0.5 * r);
  context.closePath();
  context.fill();
  context.restore();
}

function drawPlan(
  context: CanvasRenderingContext2D,
  { plan }: ChairState,
  colours: Colours,
  view: View,
): void {
  if (plan.length < 2) return;
  const line = plan.map(([x, y]): Point => [x, y]);
  context.lineCap = context.lineJoin = "round";
  context.strokeStyle = colours.plan;
  context.lineWidth = Math.max(5, 0.22 * view.scale);
  context.globalAlpha = 0.45;
  traced(context, line, view);
  context.stroke();
  context.globalAlpha = 1;
  context.lineCap = "butt";
}

/** Drawn from above: seat and footrest, two large wheels behind, two small ones ahead, the rider's head. */
function drawChair(
  context: CanvasRenderingContext2D,
  { pose }: Shown,
  { chair, colours }: Pick<Moving, "chair" | "colours">,
  view: View,
): void {
  const [x, y] = toScreen(view, pose[0], pose[1]);
  const xs = chair.outline.map((corner) => corner[0]);
  const [rear, front] = [Math.min(...xs), Math.max(...xs)];
  const half = Math.max(...chair.outline.map((corner) => Math.abs(corner[1])));
  // Far away it is drawn larger than it is, so that it is found.
  const k = Math.max(view.scale, 11 / half);
  const box = (ahead: number, left: number, long: number, wide: number, round: number): void => {
    context.beginPath();
    context.roundRect(k * (ahead - long / 2), k * (-left - wide / 2), k * long, k * wide, k * round);
    context.fill();
    context.stroke();
  };
  const long = front - rear;
  context.save();
  context.translate(x, y);
  context.rotate(-(pose[2] + view.turn));
  context.fillStyle = colours.chair;
  context.strokeStyle = colours.onChair;
  context.lineWidth = 1.5;
  const [wheel, caster] = [0.5 * long, 0.2 * long];
  for (const side of [-1, 1]) {
    box(rear + 0.42 * long, side * 0.88 * half, wheel, 0.24 * half, 0.05);
    box(front - 0.3 * long, side * 0.8 * half, caster, 0.2 * half, 0.04);
    box(front - 0.09 * long, side * 0.3 * half, 0.18 * long, 0.42 * half, 0.05); // footrest
  }
  box(rear + 0.42 * long, 0, 0.62 * long, 1.36 * half, 0.1); // seat
  box(rear + 0.09 * long, 0, 0.14 * long, 1.3 * half, 0.05); // backrest
  context.fillStyle = colours.onChair;
  context.beginPath();
  context.arc(k * (rear + 0.36 * long), 0, k * 0.34 * half, 0, 2 * Math.PI);
  context.fill();
  context.restore();
}

const RING = { free: 0, narrow: 3, blocked: 7, unseen: 0 } as const;

/** Arcs about the chair where it is narrow or blocked. */
function drawRing(context: CanvasRenderingContext2D, { pose }: Shown, moving: Moving, view: View): void {
  const { ring, chair, colours } = moving;
  if (ring.length === 0) return;
  const [x, y] = toScreen(view, pose[0], pose[1]);
  const reach = Math.max(...chair.outline.map(([ahead, left]) => Math.hypot(ahead, left)));
  const radius = Math.max(24, (reach + 0.12) * view.scale);
  const half = Math.PI / ring.length;
  context.lineCap = "butt";
  for (const { angle, freedom } of ring) {
    if (RING[freedom] === 0) continue;
    const at = -(pose[2] + angle + view.turn);
    context.strokeStyle = freedom === "blocked" ? colours.unwish : colours.space;
    context.lineWidth = RING[freedom];
    context.beginPath();
    context.arc(x, y, radius, at - half, at + half);
    context.stroke();
  }
}

/** Two rings and a mark at what the chair waits for. */
function drawCause(context: CanvasRenderingContext2D, { at }: Cause, colours: Colours, view: View): void {
  const [x, y] = toScreen(view, ...at);
  const radius = Math.max(16, 0.5 * view.scale);
  for (const [colour, width] of [[colours.free, 7], [colours.unwish, 4]] as const) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.stroke();
  }
  badge(context, "!", x, y - radius - 4, colours.unwish, colours.free);
}

function drawGoal(
  context: CanvasRenderingContext2D,
  goal: Destination,
  colours: Colours,
  view: View,
): void {
  const [x, y] = toScreen(view, goal.x, goal.y);
  pin(context, x, y, colours.route, colours.free);
}

/** A pin whose tip is at (x, y), px. */
export function pin(
  context: CanvasRenderingContext2D,
  x: number,
  y: number,
  colour: string,
  hole: string,
): void {
  context.beginPath();
  context.arc(x, y - 26, 13, 0.85 * Math.PI, 0.15 * Math.PI);
  context.lineTo(x, y);
  context.closePath();
  context.fillStyle = colour;
  context.strokeStyle = hole;
  context.lineWidth = 2;
  context.fill();
  context.stroke();
  context.beginPath();
  context.arc(x, y - 26, 5, 0, 2 * Math.PI);
  context.fillStyle = hole;
  context.fill();
}
