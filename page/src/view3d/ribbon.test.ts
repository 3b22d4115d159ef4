import { describe, expect, it } from "vitest";
import { distanceToSegment, lengthOf } from "../map/strokes";
import type { Point } from "../map/view";
import { area, around } from "./markings";
import { cut, dashes, ribbon, type Strip } from "./ribbon";

const vertices = ({ positions }: Strip): number[][] =>
  Array.from({ length: positions.length / 3 }, (_, k) => positions.slice(3 * k, 3 * k + 3));

/** z of the normals' sum is twice the area where all triangles face up. */
function areaUp(strip: Strip): number {
  const at = vertices(strip);
  let sum = 0;
  for (let k = 0; k < strip.indices.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map((n) => at[strip.indices[k + n]!]!) as [number[], number[], number[]];
    const up = (b[0]! - a[0]!) * (c[1]! - a[1]!) - (b[1]! - a[1]!) * (c[0]! - a[0]!);
    expect(up).toBeGreaterThan(0);
    sum += up / 2;
  }
  return sum;
}

describe("a ribbon", () => {
  it("lies left and right of a line along x: left is +y", () => {
    const found = vertices(ribbon([[0, 0], [2, 0]], 0.4, 0.01));
    expect(found).toEqual([[0, 0.2, 0.01], [0, -0.2, 0.01], [2, 0.2, 0.01], [2, -0.2, 0.01]]);
  });

  it("follows a curve at half its width, and faces up", () => {
    const arc = Array.from({ length: 41 }, (_, k): Point => [3 * Math.cos(k / 20), 3 * Math.sin(k / 20)]);
    const strip = ribbon(arc, 0.5, 0);
    for (const [x, y] of vertices(strip)) expect(Math.abs(Math.hypot(x!, y!) - 3)).toBeCloseTo(0.25, 3);
    expect(areaUp(strip)).toBeCloseTo(0.5 * lengthOf(arc), 2);
  });

  it("keeps its width in a corner: its edges stay parallel to the line", () => {
    const corner: Point[] = [[0, 0], [2, 0], [2, 2]];
    const [, , left, right] = vertices(ribbon(corner, 0.2, 0));
    expect(left!.slice(0, 2).map((each) => +each.toFixed(9))).toEqual([1.9, 0.1]);
    expect(right!.slice(0, 2).map((each) => +each.toFixed(9))).toEqual([2.1, -0.1]);
  });

  it("has no spike where the line turns back", () => {
    for (const [x, y] of vertices(ribbon([[0, 0], [2, 0], [0, 0.1]], 0.2, 0))) {
      expect(Math.hypot(x! - 1, y!)).toBeLessThan(1.5);
    }
  });

  it("is nothing for a point, however often it is repeated", () => {
    expect(ribbon([[1, 1], [1, 1]], 0.2, 0).indices).toEqual([]);
  });
});

describe("parts of a line", () => {
  it("run from one length to another", () => {
    expect(cut([[0, 0], [1, 0], [1, 1]], 0.5, 1.25)).toEqual([[0.5, 0], [1, 0], [1, 0.25]]);
  });

  it("are dashes with gaps between them", () => {
    const strip = dashes([[0, 0], [1, 0]], 0.1, 0, 0.2, 0.2);
    expect(areaUp(strip)).toBeCloseTo(3 * 0.2 * 0.1); // from 0, 0.4 and 0.8 m
  });
});

describe("areas", () => {
  it("face up, whichever way their outline is given", () => {
    const square: Point[] = [[0, 0], [2, 0], [2, 2], [0, 2]];
    expect(areaUp(area(square, 0))).toBeCloseTo(4);
    expect(areaUp(area([...square].reverse(), 0))).toBeCloseTo(4);
  });

  it("about a line end at their radius", () => {
    for (const point of around([[0, 0], [2, 1]], 0.5)) {
      expect(distanceToSegment(point, [0, 0], [2, 1])).toBeCloseTo(0.5);
    }
  });
});
