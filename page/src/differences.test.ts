import { describe, expect, it } from "vitest";
import { untold, withoutDoors } from "./differences.svelte";
import type { MapDifference } from "./messages";

const at = (x: number, y: number, kind: "gone" | "new" = "gone"): MapDifference => ({ kind, x, y, cells: [[x, y]] });

describe("differences from the map", () => {
  it("are no shut doors, which are told as doors", () => {
    const door = { id: 3, a: [4, 0], b: [4, 1] } as const;
    const found = [at(4.2, 0.5, "new"), at(9, 0.5, "new")];
    expect(withoutDoors(found, [door], [3])).toEqual([found[1]]);
    expect(withoutDoors(found, [door], [])).toEqual(found);
  });

  it("are told by the chair or by the way ahead, the nearest first", () => {
    const [far, ahead, near] = [at(50, 0), at(20, 1), at(2, 2)];
    expect(untold([far, ahead, near], [], [0, 0, 0], [[10, 0], [20, 0]])).toBe(near);
    expect(untold([far, ahead], [], [0, 0, 0], [[10, 0], [20, 0]])).toBe(ahead);
    expect(untold([far, ahead], [], [0, 0, 0], [])).toBeNull();
  });

  it("are told once, also when more of the place has been seen; another kind there is news", () => {
    const told = [{ kind: "gone", x: 2, y: 2 } as const];
    expect(untold([at(2.5, 2.5)], told, [0, 0, 0], [])).toBeNull();
    expect(untold([at(2.5, 2.5, "new")], told, [0, 0, 0], [])?.kind).toBe("new");
  });
});
