// A ride as it is told by the server: samples at a fixed period, and reasons with their times.

import type { Point } from "../map/view";
import type { DoorInfo, FloorInfo, PersonInfo, PlaceInfo } from "../messages";
import type { FloorSolids } from "../view3d/floorSolids";
import type { Drawn } from "../view3d/world";

export interface Timeline {
  /** Between samples, s. */
  readonly period: number;
  readonly pose: readonly (readonly [number, number, number])[];
  /** m/s, forward. */
  readonly speed: readonly number[];
  /** Rider's share of the control authority, 0…1. */
  readonly eta: readonly number[];
  /** Stick, forward and left, −1…1. */
  readonly stick: readonly (readonly [number, number])[];
  /** Of each sample: people, (x, y), m. */
  readonly people: readonly (readonly Point[])[];
  readonly reasons: readonly TimedReason[];
  readonly route: readonly Point[];
  readonly goal: Point | null;
  readonly outline: readonly Point[];
  readonly floor: RideFloor;
}

export interface TimedReason {
  readonly time: number;
  readonly duration: number;
  readonly code: string;
  readonly text: string;
}

/** Its image is the picture itself; a ride of an older program has no more than that. */
export interface RideFloor extends FloorInfo {
  readonly places?: readonly PlaceInfo[];
  readonly doors?: readonly DoorInfo[];
  readonly solids?: FloorSolids | null;
}

/** A person who is nearer than this to where one was in the sample before is the same, m (assumed). */
const SAME = 0.6;

/** What a 3-D view draws of one sample. */
export function drawnAt(ride: Timeline, k: number): Drawn {
  const before = ride.people[Math.max(0, k - 1)] ?? [];
  return {
    pose: [...(ride.pose[k] ?? ride.pose[0]!)],
    speed: ride.speed[k] ?? 0,
    turn_rate: 0,
    reason: null,
    people: (ride.people[k] ?? []).map((at, id) => personAt(at, id, before, ride.period)),
    true_people: [],
    closed_doors: [],
    plan: [],
    groups: [],
    goal: ride.goal && { name: "", x: ride.goal[0], y: ride.goal[1] },
  };
}

function personAt([x, y]: Point, id: number, before: readonly Point[], period: number): PersonInfo {
  const was = before.find((each) => Math.hypot(each[0] - x, each[1] - y) < SAME) ?? [x, y];
  const [vx, vy] = [(x - was[0]) / period, (y - was[1]) / period];
  return { id, x, y, vx, vy, radius: 0.25, axis: 0, front: 0, side: 0, rear: 0, group: -1, seen: true };
}

/** Duration of a ride, s. */
export function lengthOf(ride: Timeline): number {
  return Math.max(0, ride.pose.length - 1) * ride.period;
}

/** Number of the sample at a time. */
export function sampleAt(ride: Timeline, time: number): number {
  return Math.min(ride.pose.length - 1, Math.max(0, Math.round(time / ride.period)));
}

/** The reason at a time; null: there was none. */
export function reasonAt(ride: Timeline, time: number): TimedReason | null {
  const slack = ride.period;
  return ride.reasons.find((each) => time >= each.time - slack && time <= each.time + each.duration + slack) ?? null;
}

/** A line through values between two bounds, as an SVG path in a box of 1000 by 100. */
export function plotted(values: readonly number[], least: number, most: number): string {
  const last = Math.max(1, values.length - 1);
  return values
    .map((value, k) => {
      const share = (value - least) / (most - least || 1);
      const y = 98 - 96 * Math.min(1, Math.max(0, share));
      return `${k === 0 ? "M" : "L"}${((1000 * k) / last).toFixed(1)} ${y.toFixed(1)}`;
    })
    .join("");
}
