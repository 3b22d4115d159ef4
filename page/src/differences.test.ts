import { describe, expect, it, vi } from "vitest";
import { chair } from "./chair.svelte";
import { differences, untold, withoutDoors } from "./differences.svelte";
import type { ChairState, MapDifference, MapDifferences, SceneInfo } from "./messages";

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

  it("leave the map by themselves after 12 s where they ask for nothing, and stay where something is new", () => {
    vi.useFakeTimers();
    for (const [kind, left] of [["gone", null], ["new", "new"]] as const) {
      chair.state = { pose: [0, 0, 0], remaining: null, closed_doors: [] } as unknown as ChairState;
      chair.scene = { doors: [] } as unknown as SceneInfo;
      chair.differences = { found: [at(kind === "new" ? 1 : 2, 0, kind)] } as unknown as MapDifferences;
      differences.look();
      vi.advanceTimersByTime(11_900);
      differences.look();
      expect(differences.told?.kind).toBe(kind);
      vi.advanceTimersByTime(200);
      differences.look();
      expect(differences.told?.kind ?? null).toBe(left);
    }
    vi.useRealTimers();
  });
});
