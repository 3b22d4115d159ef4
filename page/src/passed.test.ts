import { beforeEach, expect, it } from "vitest";
import { chair } from "./chair.svelte";
import type { ActiveWish, ChairState, RouteUpdate } from "./messages";
import { isBehind, passed } from "./passed.svelte";

/** East for 10 m, then north for 10 m. */
const ROUTE: [number, number][] = [[0, 0], [10, 0], [10, 10]];
const LAB: ActiveWish = { id: 1, kind: "attract", points: [[5, 0]], radius: 0, visit: true };
const GOAL = { name: "Ward 4", x: 10, y: 10 };

function at(x: number, y: number, remaining: number, goal: ChairState["goal"] = GOAL): void {
  chair.heard({ type: "state", pose: [x, y, 0], remaining, goal, route_version: chair.route.version, ride: "" } as unknown as ChairState);
  passed.look();
}
function planned(version: number, points: RouteUpdate["points"]): void {
  chair.route = { ...chair.route, version, points, wishes: [LAB] };
}

beforeEach(() => {
  planned(1, ROUTE);
  at(0, 0, 20, null);
});

it("is passed once the chair has been there, or once the route leads only away from it", () => {
  expect(isBehind([5, 0], [1, 0, 0], ROUTE, 19)).toBe(false);
  expect(isBehind([5, 0], [4.5, 0, 0], ROUTE, 15.5)).toBe(true);
  // The route comes no nearer to it than 3 m, at 5 m: 2 m later 3.6 m are left at best, 5 m later 5.8 m.
  expect(isBehind([5, 3], [4, 0, 0], ROUTE, 16)).toBe(false);
  expect(isBehind([5, 3], [10, 5, 0], ROUTE, 5)).toBe(true);
});

it("stays passed on a new route, and not on the next trip", () => {
  at(2, 0, 18);
  expect(passed.has(LAB)).toBe(false);
  at(5, 0.2, 15);
  expect(passed.has(LAB)).toBe(true);
  planned(2, [[8, 0], [10, 10]]);
  at(8, 0, 10.2);
  expect(passed.has(LAB)).toBe(true);
  at(8, 0, 10.2, { ...GOAL, x: 0 });
  expect(passed.has(LAB)).toBe(false);
});

it("counts nothing while the route and the distance left are not of one version", () => {
  chair.heard({ type: "state", pose: [0, 3, 0], remaining: 1, goal: GOAL, route_version: 7, ride: "" } as unknown as ChairState);
  passed.look();
  expect(passed.has(LAB)).toBe(false);
});
