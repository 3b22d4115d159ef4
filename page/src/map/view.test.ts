// @vitest-environment node
import { describe, expect, it } from "vitest";
import { fitted, followed, headed, pinned, toMap, toScreen, within, zoomed, type View } from "./view";

const view: View = { at: [3, -2], middle: [200, 150], scale: 40, turn: 0.7 };

describe("the map on the screen", () => {
  it("goes there and back", () => {
    const [x, y] = toMap(view, ...toScreen(view, 5.5, 1.25));
    expect(x).toBeCloseTo(5.5, 9);
    expect(y).toBeCloseTo(1.25, 9);
  });

  it("has y up and a metre as long as the scale says", () => {
    const north = { ...view, turn: 0 };
    expect(toScreen(north, 3, -1)).toEqual([200, 110]);
    expect(toScreen(north, 4, -2)).toEqual([240, 150]);
  });

  it("turns counter-clockwise: what lies in direction 0 goes up after a quarter turn", () => {
    const [x, y] = toScreen({ ...view, turn: Math.PI / 2 }, 4, -2);
    expect(x).toBeCloseTo(200, 9);
    expect(y).toBeCloseTo(110, 9);
  });

  it("keeps the point under the finger while it zooms", () => {
    const before = toMap(view, 31, 77);
    const after = toMap(zoomed(view, 1.7, 31, 77), 31, 77);
    expect(after[0]).toBeCloseTo(before[0], 9);
    expect(after[1]).toBeCloseTo(before[1], 9);
  });

  it("zooms within bounds", () => {
    expect(zoomed(view, 1e6, 0, 0).scale).toBe(160);
    expect(zoomed(view, 1e-6, 0, 0).scale).toBe(4);
  });

  it("pins a point where it is told", () => {
    const [x, y] = toScreen(pinned(view, [9, 9], [12, 34]), 9, 9);
    expect(x).toBeCloseTo(12, 9);
    expect(y).toBeCloseTo(34, 9);
  });

  it("shows all of a box", () => {
    const all = fitted({ x: -5, y: 0, width: 40, height: 20 }, 800, 600);
    expect(all.scale).toBeCloseTo((800 - 32) / 40, 9);
    expect(toScreen(all, 15, 10)).toEqual([400, 300]);
  });
});

describe("following the chair", () => {
  it("leaves the view alone while the chair is in the middle", () => {
    const north = { at: [0, 0], middle: [200, 150], scale: 40, turn: 0 } as const;
    expect(followed(north, 0.5, 0.3, 400, 300).at).toEqual([0, 0]);
  });

  it("moves no farther than to have it at the middle's edge", () => {
    const north = { at: [0, 0], middle: [200, 150], scale: 40, turn: 0 } as const;
    const [x] = toScreen(followed(north, 10, 0, 400, 300), 10, 0);
    expect(x).toBeCloseTo(0.62 * 400, 9);
  });

  it("shows no more emptiness than must be", () => {
    const off = { at: [0, 0], middle: [200, 150], scale: 40, turn: 0 } as const;
    const wide = within(off, { x: 0, y: 0, width: 40, height: 5 }, 400, 300);
    // 40 m × 40 px fill the 400 px, so the left edge lies on the left; 5 m × 40 px = 200 px do
    // not fill the 300 px, so they lie in the middle.
    expect(toScreen(wide, 0, 5)).toEqual([0, 50]);
  });

  it("turns the heading up, to a step", () => {
    const up = headed(view, [1, 1, 0.4], 400, 300);
    const [x, y] = toScreen(up, 1 + Math.cos(0.4), 1 + Math.sin(0.4));
    expect(Math.abs(x - 200)).toBeLessThan(40 * 0.006);
    expect(y).toBeLessThan(0.7 * 300 - 39);
  });
});
