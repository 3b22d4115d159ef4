import { describe, expect, it } from "vitest";
import { chair } from "./chair.svelte";
import { differences, onTheWay, untold, withoutDoors } from "./differences.svelte";
import type { ChairState, MapDifference, MapDifferences, SceneInfo } from "./messages";

const at = (x: number, y: number, kind: "gone" | "new" = "gone"): MapDifference => ({ kind, x, y, cells: [[x, y]] });

describe("differences from the map", () => {
  it("are no shut doors, which are told as doors", () => {
    const door = { id: 3, a: [4, 0], b: [4, 1] } as const;
    const found = [at(4.2, 0.5, "new"), at(9, 0.5, "new")];
    expect(withoutDoors(found, [door], [3])).toEqual([found[1]]);
    expect(withoutDoors(found, [door], [])).toEqual(found);
  });

  it("affect the way ahead where something new stands on it, and nowhere else", () => {
    const ahead = [[0, 0], [10, 0], [20, 0]] as const;
    const [on, beside, gone] = [at(15, 0.9, "new"), at(5, 1.1, "new"), at(5, 0)];
    expect(onTheWay([on, beside, gone], ahead)).toEqual([on]);
    expect(onTheWay([on], [])).toEqual([]);
  });

  it("are told once, the nearest first, also when more of the place has been seen", () => {
    const [far, near] = [at(50, 0, "new"), at(2, 2, "new")];
    expect(untold([far, near], [], [0, 0, 0])).toBe(near);
    expect(untold([far, at(2.5, 2.5, "new")], [near], [0, 0, 0])).toBe(far);
  });

  it("are told to a rider whose way they affect, and to no other", () => {
    const state = { pose: [0, 0, 0], remaining: null, closed_doors: [] } as unknown as ChairState;
    chair.scene = { doors: [] } as unknown as SceneInfo;
    chair.route = { ...chair.route, version: 7, points: [[0, 0], [9, 0]] };
    chair.differences = { found: [at(1, 0), at(3, 0, "new")] } as unknown as MapDifferences;
    chair.state = state;
    differences.look();
    expect([differences.shown.length, differences.told]).toEqual([2, null]); // no trip
    chair.state = { ...state, remaining: 9 };
    differences.look();
    expect(differences.told?.x).toBe(3);
    chair.state = { ...state, pose: [5, 0, 0], remaining: 4 }; // behind the chair
    differences.look();
    expect(differences.told).toBeNull();
  });
});
