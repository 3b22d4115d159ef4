// @vitest-environment node
import { describe, expect, it } from "vitest";
import { distanceToSegment, drawn, farthestFrom, lastOf, lengthOf, MOST_POINTS, simplified, zoneOf } from "./strokes";
import type { Point } from "./view";

const wave = Array.from({ length: 900 }, (_, k): Point => [k / 30, Math.sin(k / 9)]);

describe("a drawn line", () => {
  it("keeps its ends and its corners only", () => {
    const line: Point[] = [[0, 0], [1, 0.01], [2, 0], [2, 1], [2, 2]];
    expect(simplified(line, 0.1)).toEqual([[0, 0], [2, 0], [2, 2]]);
  });

  it("loses no point by more than the tolerance", () => {
    const kept = simplified(wave, 0.05);
    for (const p of wave) {
      const d = Math.min(...kept.slice(1).map((b, k) => distanceToSegment(p, kept[k]!, b)));
      expect(d).toBeLessThanOrEqual(0.05 + 1e-9);
    }
  });

  it("is never longer than a message may be", () => {
    expect(drawn(wave, 0.001).length).toBeLessThanOrEqual(MOST_POINTS);
  });
});

describe("where not to go", () => {
  it("is what a closed line encloses", () => {
    const square: Point[] = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0.2]];
    expect(zoneOf(square)).toEqual({ points: square, radius: 0 });
  });

  it("is a band about an open line, as wide as it says", () => {
    const zone = zoneOf([[0, 0], [3, 0], [6, 0.5]], 0.4);
    expect(zone.points).toHaveLength(6);
    expect(zone.points[0]?.[1]).toBeCloseTo(0.4, 9);
    expect(zone.points[5]?.[1]).toBeCloseTo(-0.4, 9);
  });

  it("reaches about a straight line of two", () => {
    expect(zoneOf([[0, 0], [3, 0]], 0.4)).toEqual({ points: [[0, 0], [3, 0]], radius: 0.4 });
  });

  it("never has more points than a message may", () => {
    expect(zoneOf(wave).points.length).toBeLessThanOrEqual(MOST_POINTS);
  });
});

it("says a detour in the middle of where it is far from the other way", () => {
  const straight: Point[] = [[0, 0], [10, 0]];
  expect(farthestFrom([[0, 0], [0, 3], [10, 3], [10, 0]], straight)?.[0]).toBeCloseTo(5, 0);
  expect(farthestFrom(straight, straight)).toBeNull();
  expect(farthestFrom(straight, [])).toBeNull();
});

it("measures lines", () => {
  expect(lengthOf([[0, 0], [3, 4], [3, 5]])).toBe(6);
});

describe("the end of a line", () => {
  const line: [number, number][] = [[0, 0], [4, 0], [4, 3]];

  it("is as long as asked, and begins between the points of the line", () => {
    expect(lastOf(line, 5)).toEqual([[2, 0], [4, 0], [4, 3]]);
    expect(lastOf(line, 3)).toEqual([[4, 0], [4, 3]]);
  });

  it("is all of a shorter line, and a point of none", () => {
    expect(lastOf(line, 20)).toEqual(line);
    expect(lastOf(line, 0)).toEqual([[4, 3]]);
    expect(lastOf([], 2)).toEqual([]);
  });
});
