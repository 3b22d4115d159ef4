import { describe, expect, it } from "vitest";
import type { ChairState } from "../messages";
import type { RideSummary } from "./api";
import { breach, clock, compared, destination, details, doing, driver, duration, feeling, measuresOf, moment, outcome, shares, what, who } from "./words";

describe("words", () => {
  it("say measures in their units, only those that are there", () => {
    const measures = { min_distance: 0.512, authority: 0.334, collisions_wall: 0, jerk_felt_rms: 0.1, odd: 3 };
    expect(measuresOf({ measures }).map(({ value }) => value)).toEqual(["0.51 m", "0", "0.10 m/s³", "33 %"]);
    expect(measuresOf({ measures: {} })).toEqual([]);
  });

  it("name measures in plain words, with the technical term beside them", () => {
    const [jolts, nearest] = measuresOf({ measures: { jerk_felt_rms: 0.1, wall_distance: 0.4 } }).reverse();
    expect(jolts).toMatchObject({ name: "Jolts, on average (calm: 1 or less)", term: expect.stringContaining("RMS jerk") as string });
    expect(nearest?.term).toBe("");
  });

  it("say how a ride felt, by its jolts", () => {
    const felt = (jerk_felt_rms?: number): ReturnType<typeof feeling> =>
      feeling({ measures: jerk_felt_rms === undefined ? {} : { jerk_felt_rms } });
    expect([felt(0.4), felt(1), felt(1.01), felt(2), felt(2.1), felt()]).toEqual(["calm", "calm", "some", "some", "jerky", null]);
  });

  it("compare two sessions by the means over their rides, where a ride has the figure", () => {
    const ride = (more: Partial<RideSummary>): RideSummary => ({
      id: "", started: "", seed: 0, destination: "", outcome: "arrived", duration: 60, length: 20, modes: {}, devices: {},
      wishes: 0, limits: [], stops: [], rating: null, measures: {}, error: "", ...more,
    });
    const one = [ride({ rating: 4, measures: { min_distance: 0.4 } }), ride({ outcome: "cancelled", duration: 30 })];
    const rows = Object.fromEntries(compared(one, [ride({ rating: null })]).map(({ name, values }) => [name, values]));
    expect(rows["Rides"]).toEqual(["2", "1"]);
    expect(rows["Arrived"]).toEqual(["1", "1"]);
    expect(Object.values(rows)).toContainEqual(["45 s", "1 min 0 s"]);
    expect(Object.values(rows)).toContainEqual(["0.40 m", ""]);
    expect(Object.keys(rows)).toHaveLength(7);
  });

  it("name the nearest person before the measures are there", () => {
    const limits = [{ time: 0, limits: { max_speed: 1, max_acceleration: 1, min_distance: 0.8 } }];
    expect(breach({ limits, measures: {}, nearest: 0.3 })).toEqual({ nearest: 0.3, target: 0.8 });
    expect(breach({ limits, measures: { min_distance: 0.9 }, nearest: 0.3 })).toBeNull();
    expect(breach({ limits, measures: {} })).toBeNull();
  });

  it("say times", () => {
    expect(duration(59.4)).toBe("59 s");
    expect(duration(59.6)).toBe("1 min 0 s");
    expect(duration(125)).toBe("2 min 5 s");
    expect(moment("2026-01-31T14:25:30+00:00", "en-GB", "UTC")).toBe("31 Jan 2026, 14:25:30");
    expect(moment("some day")).toBe("some day");
    expect(clock("2026-01-31T14:25:30+00:00", "en-GB", "UTC")).toBe("14:25");
    expect(clock("2026-01-31T14:25:30+00:00", "de-DE", "UTC")).toBe("14:25");
    expect(clock("some day")).toBe("some day");
  });

  it("say what was used, the longest first", () => {
    expect(shares({ manual: 12, shared: 125, assisted: 0.2 })).toBe("shared 2 min 5 s, manual 12 s");
    expect(shares({})).toBe("none");
    expect(outcome({ outcome: "cancelled", destination: "" })).toBe("Ended");
    expect(outcome({ outcome: "cancelled", destination: "Ward A" })).toBe("Ended before arrival");
    expect(destination({ destination: "" })).toBe("no destination");
  });

  it("say what differs where there is a before and an after", () => {
    const before = { max_speed: 1, min_distance: 0.45 };
    expect(details({ before, after: { ...before, max_speed: 0.6 } })).toBe("max speed: 1 → 0.6");
    expect(details({ role: "therapist", address: "::1" })).toBe("role: therapist, address: ::1");
    expect(details({ goal: { x: 1.23456, y: 2 }, point: [1, null] })).toBe("goal: x 1.235, y 2, point: (1, none)");
    expect(details({ before, after: before })).not.toBe("");
    expect(details({})).toBe("");
  });

  it("say every kind of entry, and one that is not known yet", () => {
    expect(what({ event: "sign_in_rejected" })).toBe("Tried to sign in with a wrong token");
    expect(what({ event: "something_new" })).toBe("something new");
  });

  it("say who did it", () => {
    expect(["chair", "therapist 3", "page-9775a89f", "Ann"].map((actor) => who({ actor }))).toEqual([
      "Chair", "Therapist 3", "Page 9775a89f", "Ann",
    ]);
  });

  it("say who drives and where to", () => {
    const state = { driver: "a", device: "keys", link: "confirm", reason: null, paused: false } as ChairState;
    expect(driver(state)).toBe("The rider, with the keys");
    expect(driver({ ...state, device: "none" })).toBe("The rider; the stick is at rest");
    expect(driver({ ...state, driver: null })).toBe("No driver");
    expect(doing(state)).toBe("Driving");
    expect(doing({ ...state, goal: { name: "Ward 1", x: 0, y: 0 } })).toBe("Driving to Ward 1");
    expect(doing(null)).toBe("—");
  });
});
