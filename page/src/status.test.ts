import { afterEach, expect, it } from "vitest";
import { chair } from "./chair.svelte";
import type { ChairState, RideEnded } from "./messages";
import { standingNow } from "./status";
import { surroundings } from "./surroundings.svelte";

const WARD = { name: "Ward 1", x: 0, y: 0 };
const rolls = (more: Partial<ChairState>): void =>
  chair.heard({
    type: "state", driver: "me", link: "ready", mode: "shared", goal: WARD, ride: "", speed: 0.06, rider_authority: 0, ...more,
  } as ChairState);

afterEach(() => {
  chair.state = chair.arrival = chair.ended = null;
  surroundings.stands = true;
});

it("has arrived as soon as the trip is over, also while the chair rolls out", () => {
  chair.client = "me";
  surroundings.stands = false;
  rolls({ ride: "r1" });
  expect(standingNow()).toBe("");
  chair.heard({ type: "ride_ended", ride: "r1", outcome: "arrived", duration: 60, length: 30 } as RideEnded);
  rolls({ goal: null });
  expect(standingNow()).toBe("Arrived: Ward 1");
  // The rider steers on: who steers is told again.
  rolls({ goal: null, rider_authority: 1 });
  expect(standingNow()).toBe("");
});
