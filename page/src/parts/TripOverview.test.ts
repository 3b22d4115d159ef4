import { cleanup, fireEvent, render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { chair } from "../chair.svelte";
import { link } from "../link";
import { inputs } from "../input/live";
import { reach } from "../input/reach";
import type { ChairState, TripPlans, Welcome } from "../messages";
import { trip } from "../trip.svelte";
import StartButton from "./StartButton.svelte";
import TripOverview from "./TripOverview.svelte";
import TripPanel from "./TripPanel.svelte";

const FIGURES = { length: 9, clearance: 0.8, encounters: 1, turns: 0, doors: 0 };
const PLANS: TripPlans = {
  type: "trip_plans", id: 1, error: "", extra_length: 0, closest: [], through: [], learned: false, complete: true,
  routes: [{ points: [[0, 0], [9, 0]], length: 9, duration: 13, differences: [], via: null, figures: FIGURES }],
};
const nothing = (): void => undefined;
const button = (name: string): HTMLElement => screen.getByRole("button", { name });

beforeEach(() => {
  chair.heard({ type: "state", pose: [0, 0, 0], driver: null, link: "no_driver", goal: null } as unknown as ChairState);
});
afterEach(() => {
  cleanup();
  trip.close();
  chair.state = null;
  vi.restoreAllMocks();
});

describe("the overview of a trip", () => {
  it("offers another attempt where no answer came", async () => {
    const asking = vi.spyOn(link, "ask").mockResolvedValue({ type: "rejected", id: 1, code: "no_answer", text: "The chair did not respond." });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    render(TripOverview, { pointing: nothing, leave: nothing });
    const told = screen.getAllByRole("status")[0]!.textContent!.replace(/\s+/g, " ").trim();
    expect(told).toBe("The chair did not respond. It is tried again by itself.");
    render(StartButton);
    expect(button("Start").getAttribute("aria-disabled")).toBe("true");
    asking.mockResolvedValue(PLANS);
    await fireEvent.click(button("Try again"));
    await tick();
    expect(screen.queryByRole("button", { name: "Try again" })).toBeNull();
    expect(button("Start").getAttribute("aria-disabled")).toBe("false");
  });

  it("counts the routes, of which the last may be below the edge of the list", async () => {
    const [route] = PLANS.routes;
    vi.spyOn(link, "ask").mockResolvedValue({ ...PLANS, routes: [route, route, route] } as TripPlans);
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    render(TripOverview, { pointing: nothing, leave: nothing });
    expect(screen.getByRole("status").textContent).toContain("3 routes");
  });

  it("offers its wishes to one switch, too", async () => {
    vi.spyOn(link, "ask").mockResolvedValue(PLANS);
    const places = [{ name: "Laboratory", x: 4, y: 3, area: [], names: {} }];
    chair.heard({ type: "welcome", scene: { places } } as unknown as Welcome);
    chair.heard({ type: "state", pose: [0, 0, 0], driver: null, link: "no_driver", goal: null } as unknown as ChairState);
    inputs.scanner.change({ count: 1 });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    render(TripOverview, { pointing: nothing, leave: nothing });
    await fireEvent.click(button("Go via, avoid, draw…"));
    const opened = document.getElementById("trip-wish")!;
    const groups = reach(document).filter(({ elements }) => opened.contains(elements[0] ?? null));
    expect(groups).toHaveLength(2); // a group of one place is that place
    await fireEvent.click(screen.getAllByRole("button", { name: "Laboratory" })[1]!);
    expect(trip.draft!.wishes.map((each) => each.wish.kind)).toEqual(["avoid"]);
    inputs.scanner.change({ count: 0 });
    chair.heard({ type: "welcome", scene: null } as unknown as Welcome);
  });

  it("promises no turn while a fault holds the chair", async () => {
    const goal = { name: "Ward 4", x: 9, y: 9 };
    const points: [number, number][] = [[0, 0], [3, 0], [3, 9], [9, 9]];
    const under = (not_ready: ChairState["not_ready"]): void =>
      chair.heard({ type: "state", pose: [0, 0, 0], driver: "me", link: "ready", goal, remaining: 18, pace: "normal", not_ready } as unknown as ChairState);
    chair.route = { ...chair.route, points };
    render(TripPanel);
    under(null);
    await tick();
    expect(screen.getByRole("region").textContent).toContain("Turn left in 3 m");
    under({ code: "scan_blind", text: "The scanner cannot see ahead. Stopped." });
    await tick();
    expect(screen.getByRole("region").textContent).toContain("Trip on hold");
    expect(screen.getByRole("region").textContent).not.toContain("Turn");
    chair.route = { ...chair.route, points: [] };
  });

  it("leaves the trip to its panel when it is hidden, and forgets it when it is cancelled", async () => {
    vi.spyOn(link, "ask").mockResolvedValue(PLANS);
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    render(TripPanel);
    expect(screen.queryByRole("region")).toBeNull();
    trip.hide();
    await tick();
    await fireEvent.click(button("Show trip"));
    expect(trip.open).toBe(true);
    trip.hide();
    await tick();
    await fireEvent.click(button("Cancel trip"));
    expect(trip.draft).toBeNull();
    expect(screen.queryByRole("region")).toBeNull();
  });
});
