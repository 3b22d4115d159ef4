// @vitest-environment node
import { describe, expect, it } from "vitest";
import { causeOf, doorAhead, ring, sides, type About } from "./around";
import { pushedInto } from "./cues.svelte";
import { shareOf, steererOf } from "./share";
import { facesAway, nextTurn } from "./turns";
import type { Point } from "./map/view";

const FREE = Array.from({ length: 36 }, () => 3);
const person = (x: number, y: number, vx = 0, vy = 0) => ({
  id: 1, x, y, vx, vy, radius: 0.25, axis: 0, front: 1, side: 1, rear: 1, group: -1, seen: true,
});
const DOOR = { id: 2, a: [2, -0.5], b: [2, 0.5] } as const;
const PLACES = [{ name: "Pharmacy", x: 3, y: 0, area: [], names: {} }, { name: "Ward 1", x: -9, y: 0, area: [], names: {} }];
const scene = { doors: [{ ...DOOR, a: [2, -0.5] as [number, number], b: [2, 0.5] as [number, number] }], places: PLACES };

function about(more: Partial<About> = {}): About & { remaining: number } {
  return { pose: [0, 0, 0], people: [], free: FREE, closed_doors: [], remaining: 5, ...more };
}

const blockedAhead = (d: number): number[] => FREE.map((free, k) => (k === 0 ? d : free));
const ROUTE: Point[] = [[0, 0], [5, 0]];

describe("the ring", () => {
  it("says what is free, narrow, blocked and not seen", () => {
    const free = FREE.map((d, k) => [0.2, 0.6, d, -1][k] ?? d);
    const found = ring(about({ free }), scene, () => false);
    expect(found.slice(0, 4).map((each) => each.freedom)).toEqual(["blocked", "narrow", "free", "unseen"]);
  });

  it("says by what: a person, a shut door, a wall, something else", () => {
    const at = (more: Partial<About>, wall = false): string | null =>
      ring(about({ free: blockedAhead(0.2), ...more }), scene, () => wall)[0]!.by;
    expect(at({ people: [person(0.8, 0.1)] })).toBe("person");
    expect(at({ pose: [1.3, 0, 0], closed_doors: [2] })).toBe("door");
    expect(at({}, true)).toBe("wall");
    expect(at({})).toBe("object");
  });

  it("is told in sides to those who do not see it", () => {
    const found = ring(about({ free: blockedAhead(0.1) }), scene, () => true);
    expect(sides(found)).toEqual([{ side: "ahead", by: "wall" }]);
  });

  it("is without any where no scanner tells", () => {
    expect(ring(about({ free: [] }), scene, () => true)).toEqual([]);
  });
});

describe("a shut door on the way", () => {
  it("is what comes next, with the way to it", () => {
    const found = doorAhead({ closed_doors: [2] }, scene, ROUTE, 4);
    expect(found?.cause).toMatchObject({ thing: "door", name: "Pharmacy" });
    expect(found?.after).toBeCloseTo(1); // the chair is at 1 m, the door at 2 m
  });

  it("is none where it is open, beside the route, or passed", () => {
    expect(doorAhead({ closed_doors: [] }, scene, ROUTE, 4)).toBeNull();
    expect(doorAhead({ closed_doors: [2] }, scene, [[0, 3], [5, 3]], 4)).toBeNull();
    expect(doorAhead({ closed_doors: [2] }, scene, ROUTE, 2)).toBeNull();
  });
});

describe("the cause of a stop", () => {
  const cause = (more: Partial<About>, wall = false) => causeOf(about(more), scene, ROUTE, () => wall);

  it("is the shut door on the route, by the name of the place behind it", () => {
    expect(cause({ closed_doors: [2] })).toMatchObject({ thing: "door", name: "Pharmacy", at: [2, 0] });
  });

  it("is the nearest person ahead, and what they do", () => {
    expect(cause({ people: [person(2, 0.5, 0, -0.8)] })).toMatchObject({ thing: "person", moves: "crossing" });
    expect(cause({ people: [person(2, 0, -0.8, 0)] })).toMatchObject({ moves: "coming" });
    expect(cause({ people: [person(2, 0)] })).toMatchObject({ moves: "standing", at: [2, 0] });
    expect(cause({ people: [person(-2, 0)] })).toBeNull();
  });

  it("else is what is measured ahead, a wall if the map has one there", () => {
    expect(cause({ free: blockedAhead(0.3) }, true)).toMatchObject({ thing: "wall" });
    expect(cause({ free: blockedAhead(0.3) })).toMatchObject({ thing: "object", at: [0.8, 0] });
    expect(cause({})).toBeNull();
  });
});

describe("a cue", () => {
  it("is about the direction of the stick, and silent at rest", () => {
    const directions = ring(about({ free: FREE.map((d, k) => (k === 9 ? 0.1 : d)) }), scene, () => true);
    expect(pushedInto(directions, { forward: 0, left: 1 })).toBe("blocked");
    expect(pushedInto(directions, { forward: 1, left: 0 })).toBe("free");
    expect(pushedInto(directions, { forward: 0, left: -1 })).toBe("free");
    expect(pushedInto(directions, { forward: 0.05, left: 0 })).toBeNull();
  });
});

describe("who steers", () => {
  it("is nobody while nothing moves, whatever the share is", () => {
    expect(shareOf({ speed: 0, turn_rate: 0, rider_authority: 1 })).toBeNull();
    expect(shareOf({ speed: 0.5, turn_rate: 0, rider_authority: 0.4 })).toBe(0.4);
    expect([0, 0.5, 1].map(steererOf)).toEqual(["chair", "both", "you"]);
  });
});

describe("the next turn", () => {
  const corner: Point[] = [[0, 0], [10, 0], [10, 8]];

  it("is told with its side, its distance and its place", () => {
    const turn = nextTurn(corner, 18)!;
    expect(turn.side).toBe("left");
    expect(turn.after).toBeCloseTo(10, 0);
    expect(turn.at[0]).toBeCloseTo(10, 0);
    expect(nextTurn([[0, 0], [10, 0], [10, -8]], 18)?.side).toBe("right");
  });

  it("comes nearer on the way, and is gone when it is passed", () => {
    expect(nextTurn(corner, 12)!.after).toBeCloseTo(4, 0);
    expect(nextTurn(corner, 6)).toBeNull();
    expect(nextTurn([], 5)).toBeNull();
  });

  it("comes after turning around where the chair has its back to the way", () => {
    const line: [number, number][] = [[0, 0], [10, 0]];
    expect(facesAway(line, 8, Math.PI)).toBe(true);
    expect(facesAway(line, 8, 2.3)).toBe(true);
    expect(facesAway(line, 8, 1.8)).toBe(false);
    expect(facesAway(line, 8, -0.4)).toBe(false);
    expect(facesAway(line, 1, Math.PI)).toBe(false); // too little is left to have a direction
  });

  it("is none where a line only wavers", () => {
    const wavers = Array.from({ length: 50 }, (_, k): Point => [0.2 * k, 0.03 * (k % 2)]);
    expect(nextTurn(wavers, 9.8)).toBeNull();
  });
});
