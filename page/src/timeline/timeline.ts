// A ride as it is told by the server: samples at a fixed period, and reasons with their times.

import type { Point } from "../map/view";

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
  readonly floor: TimelineFloor;
}

export interface TimedReason {
  readonly time: number;
  readonly duration: number;
  readonly code: string;
  readonly text: string;
}

export interface TimelineFloor {
  /** Address of a picture, or the picture itself. */
  readonly image: string;
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
  readonly resolution: number;
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
