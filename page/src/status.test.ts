import { afterEach, expect, it, vi } from "vitest";
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
  vi.restoreAllMocks();
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

it("tells of no lost connection between taking control and the first heartbeat", () => {
  chair.client = "me";
  surroundings.stands = true;
  const reason = { code: "connection_lost", text: "Connection to the driver's screen lost. Stopped." };
  rolls({ driver: null, link: "no_driver", speed: 0 });
  rolls({ link: "no_heartbeat", speed: 0, reason });
  expect(standingNow()).toBe("Standing: the route is being planned");
  expect(chair.displayedState?.reason).toBeNull();
  // A second later it is lost indeed.
  const now = performance.now();
  vi.spyOn(performance, "now").mockReturnValue(now + 1_100);
  rolls({ link: "no_heartbeat", speed: 0, reason });
  expect(standingNow()).toBe("Standing: this screen has lost the connection");
});

it("tells of no lost connection where a heartbeat is late for a moment only", () => {
  chair.client = "me";
  surroundings.stands = true;
  const began = performance.now();
  const clock = vi.spyOn(performance, "now");
  const at = (after: number, link: ChairState["link"]): string => {
    clock.mockReturnValue(began + after);
    rolls({ link, speed: 0 });
    return standingNow();
  };
  const planned = "Standing: the route is being planned";
  expect(at(0, "ready")).toBe(planned);
  expect(at(5_000, "no_heartbeat")).toBe(planned);
  expect(at(5_300, "no_heartbeat")).toBe(planned);
  expect(at(5_350, "ready")).toBe(planned);
  expect(at(6_000, "no_heartbeat")).toBe(planned);
  expect(at(6_450, "no_heartbeat")).toBe("Standing: this screen has lost the connection");
});

it("names a reason that was too short to be displayed, by its cause where one is seen", () => {
  chair.client = "me";
  surroundings.stands = true;
  rolls({ speed: 0, turn_rate: 0, reason: null });
  chair.route = { ...chair.route, points: [[0, 0], [1, 0]] };
  const reason = { code: "blocked", text: "Obstacle in the way. Stopped." };
  surroundings.held = { reason, cause: null };
  expect(standingNow()).toBe("Standing: Obstacle in the way.");
  surroundings.held = { reason, cause: { thing: "person", at: [1, 0], moves: "crossing" } };
  expect(standingNow()).toBe("Standing: A person is crossing.");
  surroundings.held = { reason: { code: "over_limits", text: "Slowed down to the chair's limits." }, cause: null };
  expect(standingNow()).toBe("Standing for a moment");
  surroundings.held = { reason: { code: "no_driver", text: 'Stopped. Tap "Drive from this screen".' }, cause: null };
  expect(standingNow()).toBe("Setting off");
  surroundings.held = null;
  expect(standingNow()).toBe("Setting off");
});

it("goes on telling what a chair waits for where a heartbeat is late for a moment", () => {
  chair.client = "me";
  const began = performance.now();
  const clock = vi.spyOn(performance, "now");
  for (const [after, link] of [[0, "no_heartbeat"], [2_000, "confirm"], [4_000, "no_heartbeat"]] as const) {
    clock.mockReturnValue(began + after);
    rolls({ link, speed: 0 });
  }
  expect(chair.displayedState?.link).toBe("confirm");
});
