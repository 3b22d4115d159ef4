// @vitest-environment node
import { describe, expect, it } from "vitest";
import { detourOf, fits } from "./detour";
import type { Point } from "./view";

const straight: [number, number][] = [[0, 0], [10, 0]];
const round: [number, number][] = [[0, 0], [0, 3], [10, 3], [10, 0]];

describe("the detour on the map", () => {
  it("is told in the middle of where it leads, in one line", () => {
    const found = detourOf({ points: round, without_wishes: straight, extra_length: 4.92 });
    expect(found?.text).toBe("+4.9 m");
    expect(found?.at[0]).toBeCloseTo(5, 0);
    expect(detourOf({ points: straight, without_wishes: straight, extra_length: 0.02 })).toBeNull();
  });

  it("is whole and under nothing, or absent", () => {
    const screen = { left: 0, top: 40, right: 300, bottom: 400 };
    const at = (x: number, y: number, clear: Point[] = []): boolean =>
      fits(60, [x, y], screen, clear.map(([cx, cy]) => ({ x: cx, y: cy, radius: 26 })));
    expect(at(150, 200)).toBe(true);
    expect(at(29, 200)).toBe(false); // 60 wide: 30 px to each side
    expect(at(280, 200)).toBe(false);
    expect(at(150, 51)).toBe(false); // 24 high, messages above 40
    expect(at(150, 395)).toBe(false);
    expect(at(150, 200, [[190, 200]])).toBe(false); // the chair, 10 px from its end
    expect(at(150, 200, [[210, 200]])).toBe(true); // 30 px from it
  });
});
