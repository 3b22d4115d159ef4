// One instant of a ride on a canvas: floor, route, track, people, chair.

import { boxOf, fitted, toScreen, type Box, type Point, type View } from "../map/view";
import type { Colours } from "../map/palette";
import type { Timeline } from "./timeline";

const MARGIN = 3;

/** The part of the floor that the ride took place on. */
export function viewOf(ride: Timeline, width: number, height: number): View {
  const track = ride.pose.map(([x, y]): Point => [x, y]);
  const box: Box = boxOf([...track, ...ride.route]) ?? { x: 0, y: 0, width: 1, height: 1 };
  const wider = {
    x: box.x - MARGIN,
    y: box.y - MARGIN,
    width: box.width + 2 * MARGIN,
    height: box.height + 2 * MARGIN,
  };
  return fitted(wider, width, height, 4);
}

export function drawRide(
  context: CanvasRenderingContext2D,
  ride: Timeline,
  at: number,
  view: View,
  colours: Colours,
  floor: CanvasImageSource | null,
): void {
  const { floor: of } = ride;
  if (floor) {
    const [x, y] = toScreen(view, of.x, of.y + of.height * of.resolution);
    const scale = view.scale * of.resolution;
    context.drawImage(floor, x, y, of.width * scale, of.height * scale);
  }
  context.lineJoin = context.lineCap = "round";
  traced(context, ride.route, view, colours.without, 3);
  traced(context, ride.pose.map(([x, y]): Point => [x, y]), view, colours.route, 2);
  traced(context, ride.pose.slice(0, at + 1).map(([x, y]): Point => [x, y]), view, colours.plan, 4);
  context.fillStyle = colours.person;
  for (const person of ride.people[at] ?? []) {
    const [x, y] = toScreen(view, ...person);
    context.beginPath();
    context.arc(x, y, Math.max(3, 0.25 * view.scale), 0, 2 * Math.PI);
    context.fill();
  }
  const pose = ride.pose[at];
  if (pose) drawChair(context, ride, pose, view, colours);
}

function drawChair(
  context: CanvasRenderingContext2D,
  { outline }: Timeline,
  pose: readonly [number, number, number],
  view: View,
  colours: Colours,
): void {
  const [x, y] = toScreen(view, pose[0], pose[1]);
  const half = Math.max(...outline.map((corner) => Math.abs(corner[1])), 0.1);
  const front = Math.max(...outline.map((corner) => corner[0]), 0.1);
  const k = Math.max(view.scale, 8 / half);
  context.save();
  context.translate(x, y);
  context.rotate(-pose[2]);
  context.fillStyle = colours.chair;
  context.strokeStyle = colours.onChair;
  context.beginPath();
  for (const [ahead, left] of outline) context.lineTo(k * ahead, -k * left);
  context.closePath();
  context.fill();
  context.stroke();
  context.fillStyle = colours.onChair;
  context.beginPath();
  context.moveTo(k * front * 0.8, 0);
  context.lineTo(k * front * 0.1, k * half * 0.6);
  context.lineTo(k * front * 0.1, -k * half * 0.6);
  context.closePath();
  context.fill();
  context.restore();
}

function traced(
  context: CanvasRenderingContext2D,
  line: readonly Point[],
  view: View,
  colour: string,
  width: number,
): void {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  for (const point of line) context.lineTo(...toScreen(view, ...point));
  context.stroke();
}
