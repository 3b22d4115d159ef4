import { describe, expect, it } from "vitest";
import type { Point } from "../map/view";
import { areaOf, isInside, maskOf, regionsOf, without, type Mask } from "./contours";

/** Rows as one reads them: the first one is the top. */
function drawn(...rows: string[]): Mask {
  const cells = Uint8Array.from([...rows].reverse().flatMap((row) => [...row].map((c) => (c === "#" ? 1 : 0))));
  return { width: rows[0]!.length, height: rows.length, cells };
}

const sorted = (points: readonly Point[]): string[] => points.map(([x, y]) => `${x} ${y}`).sort();

describe("outlines of walls", () => {
  it("go round a cell anticlockwise, along its edges", () => {
    const [only, ...others] = regionsOf(drawn("...", ".#.", "..."));
    expect(others).toEqual([]);
    expect(sorted(only!.outer)).toEqual(["1 1", "1 2", "2 1", "2 2"]);
    expect(areaOf(only!.outer)).toBe(1);
    expect(only!.holes).toEqual([]);
  });

  it("have a hole for each room, clockwise", () => {
    const [only] = regionsOf(drawn("#######", "#..#..#", "#..#..#", "#######"));
    expect(areaOf(only!.outer)).toBe(28);
    expect(only!.holes.map(areaOf)).toEqual([-4, -4]);
  });

  it("give a hole to the ring that it is in, also inside of another room", () => {
    const rows = ["#########", "#.......#", "#.#####.#", "#.#...#.#", "#.#...#.#", "#.#####.#", "#.......#", "#########"];
    const found = regionsOf(drawn(...rows)).map(({ outer, holes }) => [areaOf(outer), holes.map(areaOf)]);
    expect(found).toEqual([[72, [-42]], [20, [-6]]]);
  });

  it("keep cells apart that touch at a corner only", () => {
    const found = regionsOf(drawn("#.", ".#"));
    expect(found.map(({ outer }) => areaOf(outer))).toEqual([1, 1]);
  });

  it("cover as much as the cells do, stairs of a slanted wall included", () => {
    const size = 40;
    const cells = new Uint8Array(size * size);
    for (let row = 0; row < size; row++)
      for (let k = 0; k < size; k++) cells[row * size + k] = Math.abs(row - 0.5 * k - 8) < 4 ? 1 : 0;
    const [only, ...others] = regionsOf({ width: size, height: size, cells });
    expect(others).toEqual([]);
    const filled = cells.reduce((sum, each) => sum + each, 0);
    expect(Math.abs(areaOf(only!.outer) - filled)).toBeLessThan(0.06 * filled);
    expect(only!.outer.length).toBeLessThan(12); // not one corner for each step
  });
});

describe("cells", () => {
  it("are solid where the picture is dark; its first row is the top", () => {
    const pixels = Uint8ClampedArray.from([0, 128, 255, 255].flatMap((grey) => [grey, grey, grey, 255]));
    expect([...maskOf(pixels, 2, 2).cells]).toEqual([0, 0, 1, 0]);
  });

  it("are free below furniture whose outline has their centres", () => {
    const mask = drawn("####", "####");
    const cleared = without(mask, [[[0.6, -1], [2.6, -1], [2.6, 1], [0.6, 1]]]);
    // Of the lower row the centres 1.5 and 2.5 lie within 0.6 to 2.6, and 0.5 does not.
    expect([...cleared.cells]).toEqual([1, 0, 0, 1, 1, 1, 1, 1]);
    expect([...mask.cells]).toEqual(Array(8).fill(1));
  });

  it("know inside from outside", () => {
    const square: Point[] = [[0, 0], [2, 0], [2, 2], [0, 2]];
    expect(isInside([1, 1], square)).toBe(true);
    expect(isInside([3, 1], square)).toBe(false);
  });
});
