import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { chair } from "./chair.svelte";
import { link, type Question } from "./link";
import { selection } from "./mapSelection.svelte";
import type { ChairState, RideEnded, SceneInfo } from "./messages";
import { onward } from "./onward.svelte";
import { trip } from "./trip.svelte";

const place = (name: string, x: number) => ({ name, x, y: 0, area: [], names: {} });
const BUILDING = {
  places: [place("Foyer", 0), place("Lift A", 9), place("Lift B", 5)],
  storey: "Level 1",
  storeys: [
    { name: "Level 1", places: ["Foyer", "Lift A", "Lift B"], lifts: [] },
    { name: "Level 2", places: ["Ward 3"], lifts: ["Lift A", "Lift B"] },
    { name: "Roof", places: ["Garden"], lifts: [] },
  ],
} as unknown as SceneInfo;
const [, UPPER, ROOF] = BUILDING.storeys!;

let asked: Question[];

function state(goal: string | null): void {
  chair.heard({ type: "state", pose: [0, 0, 0], driver: "me", link: "ready", goal: goal && { name: goal, x: 5, y: 0 } } as unknown as ChairState);
}

beforeEach(() => {
  asked = [];
  chair.scene = BUILDING;
  chair.status = "open";
  chair.client = "me";
  state(null);
  vi.spyOn(link, "send").mockReturnValue(true);
  vi.spyOn(link, "ask").mockImplementation((question) => {
    asked.push(question);
    return Promise.resolve({ type: "accepted", id: 1 });
  });
});
afterEach(() => {
  trip.close();
  onward.cancel();
  chair.scene = chair.state = chair.arrival = null;
  chair.status = "connecting";
});

function reach(name: string): void {
  state(name);
  onward.look();
  trip.close();
  chair.heard({ type: "ride_ended", ride: "r", outcome: "arrived" } as RideEnded);
  state(null);
  onward.look();
}

it("goes to the nearest lift, waits for the rider's word there, and goes on to the place", () => {
  onward.choose("Ward 3", UPPER!);
  expect(trip.draft?.name).toBe("Lift B");
  expect(onward.there).toBe(false);
  reach("Lift B");
  expect(onward.there).toBe(true);
  onward.arrive();
  expect(asked.at(-1)).toEqual({ type: "change_storey", storey: "Level 2" });
  chair.scene = { ...BUILDING, storey: "Level 2", places: [place("Ward 3", 3)] };
  onward.look();
  expect(trip.draft?.name).toBe("Ward 3");
  expect(onward.to).toBeNull();
});

it("another destination, or a trip that is cancelled on the way, ends it", () => {
  onward.choose("Ward 3", UPPER!);
  void trip.choose({ place: "Foyer" }, "Foyer");
  onward.look();
  expect(onward.to).toBeNull();
  onward.choose("Ward 3", UPPER!);
  state("Lift B");
  onward.look();
  trip.close();
  state(null);
  onward.look(performance.now() + 5_000);
  expect(onward.to).toBeNull();
});

it("without a lift to that storey it says so", () => {
  onward.choose("Garden", ROOF!);
  expect(selection.refusal).toBe("No lift leads to Roof.");
  expect(trip.draft).toBeNull();
});
