// @vitest-environment node
import { describe, expect, it } from "vitest";
import { overlap, placed, type Label } from "./labels";

const label = (name: string, x: number, y = 0): Label => ({ name, x, y, width: 60, height: 16 });

describe("names on the map", () => {
  it("do not lie on each other, however near their places are", () => {
    const labels = Array.from({ length: 40 }, (_, k) => label(`${k}`, 17 * (k % 8), 11 * Math.floor(k / 8)));
    const shown = placed(labels);
    for (const [k, a] of shown.entries()) {
      for (const b of shown.slice(k + 1)) expect(overlap(a, b)).toBe(false);
    }
  });

  it("stand on their places where there is room", () => {
    expect(placed([label("a", 0), label("b", 200)]).map(({ x }) => x)).toEqual([0, 200]);
  });

  it("give way to those that come first", () => {
    const shown = placed([label("first", 0), label("second", 10)]);
    expect(shown[0]).toMatchObject({ x: 0, y: 0 });
    expect(shown[1]?.y).not.toBe(0);
  });

  it("lie where they cover the fewest walls, and stay there while the map turns", () => {
    const wall = ({ y }: { y: number }): number => (Math.abs(y) < 10 ? 1 : 0);
    const [one] = placed([label("a", 0)], [], wall);
    expect(Math.abs(one!.y)).toBeGreaterThan(10);
    const [again] = placed([label("a", 0)], [one!], () => 0);
    expect(again!.aside).toBe(one!.aside);
  });
});
