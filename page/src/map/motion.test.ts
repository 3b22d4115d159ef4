// @vitest-environment node
import { describe, expect, it } from "vitest";
import type { PersonInfo } from "../messages";
import { between, mixedAngle, Motion, placed, type Shown } from "./motion";

const person = (id: number, x: number): PersonInfo => ({
  id, x, y: 0, vx: 1, vy: 0, radius: 0.25, axis: 0, front: 1, side: 0.6, rear: 0.5, group: -1, seen: true,
});
const at = (x: number, people: PersonInfo[] = []): Shown => ({ pose: [x, 0, 0], people, true_people: [] });

describe("between two states", () => {
  it("begins with the one and ends with the other", () => {
    expect(between(at(0), at(0.5), 0).pose[0]).toBe(0);
    expect(between(at(0), at(0.5), 1).pose[0]).toBe(0.5);
    expect(between(at(0), at(0.5), 0.5).pose[0]).toBe(0.25);
  });

  it("turns the short way round", () => {
    expect(mixedAngle(3.1, -3.1, 0.5)).toBeCloseTo(Math.PI, 9);
  });

  it("follows people by their number, and shows who is new where they are", () => {
    const shown = between(at(0, [person(1, 0)]), at(0, [person(2, 5), person(1, 0.4)]), 0.5);
    expect(shown.people.map((p) => [p.id, p.x])).toEqual([[2, 5], [1, 0.2]]);
  });

  it("does not draw a jump as a movement", () => {
    expect(between(at(0), at(4), 0.1).pose[0]).toBe(4);
  });
});

describe("motion", () => {
  it("takes as long as states do, and then rests", () => {
    const motion = new Motion();
    motion.put(at(0), 0);
    motion.put(at(0.1), 50);
    expect(motion.at(75)?.pose[0]).toBeCloseTo(0.05, 9);
    expect(motion.at(100)?.pose[0]).toBeCloseTo(0.1, 9);
    expect(motion.moving(99)).toBe(true);
    expect(motion.moving(101)).toBe(false);
  });

  it("does not go back before a state for a frame that is dated earlier", () => {
    const motion = new Motion();
    motion.put(at(0), 0);
    motion.put(at(0.1), 50);
    expect(motion.at(40)?.pose[0]).toBe(0);
  });

  it("shows only states where motion is not wanted", () => {
    const motion = new Motion();
    motion.put(at(0), 0);
    motion.put(at(0.1), 50);
    expect(motion.at(51, true)?.pose[0]).toBe(0.1);
  });
});

it("is nowhere while it gets ready and no world is there", () => {
  const reason = { code: "starting", text: "" };
  expect(placed({ pose: [0, 0, 0], reason })).toBe(false);
  expect(placed({ pose: [3, 0, 0], reason })).toBe(true);
  expect(placed({ pose: [0, 0, 0], reason: null })).toBe(true);
});
