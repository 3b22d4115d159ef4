import { describe, expect, it } from "vitest";
import type { PlaceInfo } from "./messages";
import type { Point } from "./map/view";
import { newsOf, type Change } from "./routeNews.svelte";

/** Along the x axis, and round by y = 6. */
const STRAIGHT: Point[] = [[0, 0], [20, 0]];
const ROUND: Point[] = [[0, 0], [0, 6], [20, 6], [20, 0]];
const NORTH = { name: "North corridor", x: 10, y: 6, area: [[-1, 5], [21, 5], [21, 7], [-1, 7]] } as unknown as PlaceInfo;
const DOOR = { id: 3, a: [10, -0.5], b: [10, 0.5] } as never;
const SCENE = { doors: [DOOR], places: [NORTH] };
const STATE = { pose: [0, 0, 0] as const, people: [], free: [], closed_doors: [] };

function news(more: Partial<Change["now"]> = {}, state: Partial<typeof STATE> = {}): string {
  const now = { points: ROUND, length: 32, cause: "blocked", ...more } as Change["now"];
  return newsOf({ before: { points: STRAIGHT }, now, left: 20 }, { ...STATE, ...state } as never, SCENE as never);
}

describe("the news of a changed route", () => {
  it("say why, where it leads and by how much it is longer", () => {
    expect(news()).toBe("New route: the way was blocked. Now through North corridor, +12 m.");
    expect(news({ cause: "stalled", length: 20.4 })).toBe(
      "New route: there was no progress. Now through North corridor, as long as before.",
    );
  });

  it("name the shut door on the old route", () => {
    expect(news({}, { closed_doors: [3] as never })).toBe(
      "New route. The door to North corridor is shut. Now through North corridor, +12 m.",
    );
  });

  it("are none if it is the same way, or the rider's own choice", () => {
    expect(news({ points: [[0, 0], [10, 1], [20, 0]] })).toBe("");
    expect(news({ cause: "goal" })).toBe("");
    expect(news({ cause: "wish" })).toBe("");
    expect(news({ cause: "first" })).toBe("");
  });
});
