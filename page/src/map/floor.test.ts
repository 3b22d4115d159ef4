// @vitest-environment node
import { expect, it } from "vitest";
import { shadesOf } from "./floor";
import { unseen } from "./figures";
import { rgbOf } from "./palette";

it("gives walls, the unknown and the free their colours", () => {
  const shades = shadesOf([10, 20, 30], [100, 110, 120], [250, 251, 252]);
  const of = (grey: number): number[] => [...shades.slice(3 * grey, 3 * grey + 3)];
  expect(of(0)).toEqual([10, 20, 30]);
  expect(of(128)).toEqual([100, 110, 120]);
  expect(of(255)).toEqual([250, 251, 252]);
});

it("reads colours", () => {
  expect(rgbOf("#0b5c8f")).toEqual([11, 92, 143]);
});

it("rings only those whom the chair does not see", () => {
  const seen = { id: 1, x: 0.2, y: 0, vx: 0, vy: 0, radius: 0.25, axis: 0, front: 1, side: 1, rear: 1, group: -1, seen: true };
  expect(unseen({ true_people: [[0, 0, 0.25], [4, 0, 0.25]], people: [seen] })).toEqual([[4, 0, 0.25]]);
});
