// @vitest-environment node
import { describe, expect, it } from "vitest";
import { MapHeading } from "./heading";

const FRAME = 1_000 / 60;
const DEGREE = Math.PI / 180;

/** Headings of the map, frame by frame, while the chair turns as told, rad and s. */
function followed(chair: (seconds: number) => number, seconds: number, still = false): number[] {
  const map = new MapHeading();
  return Array.from({ length: Math.round(seconds * 60) }, (_, k) => map.follow(chair((k * FRAME) / 1_000), k * FRAME, still));
}
const rates = (headings: number[]): number[] => headings.slice(1).map((each, k) => Math.abs(each - headings[k]!) * 60);

describe("the map's heading", () => {
  it("follows a turn of 90 degrees at no more than 30 degrees a second for a lag of 45, and then rests there", () => {
    // The chair turns at 0.6 rad/s for 2.6 s: the lag stays below 45 degrees, and the rate at its limit.
    const map = followed((s) => Math.min(Math.PI / 2, 0.6 * s), 8);
    expect(Math.max(...rates(map))).toBeLessThan(30.1 * DEGREE);
    expect(Math.abs(map.at(-1)! - Math.PI / 2)).toBeLessThan(0.011);
    expect(map.at(-1)).toBe(map.at(-60));
  });

  it("never lags so far that ahead is below the middle", () => {
    // At 1.5 rad/s: lag = 45 degrees + (1.5 − 0.52) / 2 = 73 degrees.
    const turns = (s: number): number => 1.5 * s;
    const lags = followed(turns, 6).map((each, k) => turns((k * FRAME) / 1_000) - each);
    expect(Math.max(...lags)).toBeLessThan(75 * DEGREE);
  });

  it("begins and ends gently", () => {
    const turn = rates(followed((s) => (s > 0 ? 40 * DEGREE : 0), 6)).filter((each) => each > 0);
    const changes = turn.slice(1).map((each, k) => each - turn[k]!);
    expect(Math.max(...changes)).toBeLessThan(0.01); // it slows down evenly
  });

  it("rests while the chair sways by less than 3 degrees", () => {
    expect(new Set(followed((s) => 2.8 * DEGREE * Math.sin(9 * s), 3)).size).toBe(1);
  });

  it("goes the short way round", () => {
    const map = followed((s) => (s > 0 ? -3.1 : 3.1), 3);
    expect(map.at(-1)! - 3.1).toBeCloseTo(2 * Math.PI - 6.2, 1);
  });

  it("turns at once, and seldom, where motion is not wanted", () => {
    const map = followed((s) => 0.6 * s, 2.6, true);
    // 0.6 rad/s × 2.6 s = 89 degrees: two steps of a little more than 30.
    expect(new Set(map).size).toBe(3);
  });

  it("begins anew with the chair's own", () => {
    const map = new MapHeading();
    map.follow(0, 0, false);
    map.reset();
    expect(map.follow(2, 1, false)).toBe(2);
  });
});
