import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { chair } from "./chair.svelte";
import { link, type Question } from "./link";
import type { ChairState, FromPage, PlaceInfo, RideEnded, RiderSettings, RouteUpdate, TripPlans } from "./messages";
import { selection } from "./mapSelection.svelte";
import { trip } from "./trip.svelte";
import { avoidWish, named, viaWish } from "./wishes";

const RIDER: RiderSettings = { tremor_filter: 0, dead_zone: 0.1, dwell: 1, start_at_once: false, switches: null };
const FIGURES = { length: 9, clearance: 0.8, encounters: 1, turns: 0, doors: 0 };
const ROUTE = { points: [[0, 0], [9, 0]] as [number, number][], length: 9, duration: 13, differences: [], via: null, figures: FIGURES };
const PLANS: TripPlans = {
  type: "trip_plans", id: 1, error: "", extra_length: 0, closest: [0.2, 2.4], through: [3], learned: false, complete: true,
  routes: [ROUTE, { ...ROUTE, length: 12, via: [6, 2] }],
};

type Wish = RouteUpdate["wishes"][number];
const wish = (kind: "attract" | "avoid"): Wish => ({ kind, points: [[4, 3]], radius: 1, id: 1, visit: false });

let asked: Question[];
let sent: FromPage[];

function state(more: Partial<ChairState> = {}): void {
  chair.heard({ type: "state", pose: [0, 0, 0], driver: "me", link: "ready", goal: null, ...more } as ChairState);
}

beforeEach(() => {
  [asked, sent] = [[], []];
  chair.client = "me";
  chair.rider = RIDER;
  state();
  vi.spyOn(link, "send").mockImplementation((message) => sent.push(message) > 0);
  vi.spyOn(link, "ask").mockImplementation((question) => {
    asked.push(question);
    return Promise.resolve(question.type === "plan_trip" ? PLANS : { type: "accepted", id: 1 });
  });
});
afterEach(() => {
  trip.close();
  chair.state = null;
  chair.client = "";
  vi.restoreAllMocks();
});

const goals = (): Question[] => asked.filter((each) => each.type === "set_goal");

describe("a trip", () => {
  it("is planned when it is chosen, and begins by Start only", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect(trip.routes).toHaveLength(2);
    expect(goals()).toEqual([]);
    await trip.start();
    const choice = { figures: [FIGURES, FIGURES], taken: 0 };
    expect(goals()).toEqual([{ type: "set_goal", place: "Ward 4", wishes: [], choice }]);
    expect(trip.draft).toBeNull();
  });

  it("by an alternative wishes for its point", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    trip.pick(1);
    await trip.start();
    expect(goals()).toMatchObject([{ wishes: [{ kind: "attract", points: [[6, 2]] }] }]);
    // Its point is no wish that a change would keep beside the next alternative's.
    state({ goal: { x: 9, y: 0, name: "Ward 4" } });
    chair.route = { ...chair.route, wishes: [{ ...wish("attract"), points: [[6, 2]] }, wish("avoid")] };
    await trip.change();
    expect(trip.draft!.wishes.map((each) => each.wish.kind)).toEqual(["avoid"]);
    chair.route = { ...chair.route, wishes: [] };
  });

  it("keeps no wish of the trip before for another destination", async () => {
    chair.route = { ...chair.route, wishes: [wish("attract"), wish("avoid")] };
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect(trip.draft!.wishes).toEqual([]);
    trip.close();
    state({ goal: { x: 9, y: 0, name: "Ward 4" } });
    await trip.change();
    expect(trip.draft!.wishes.map((each) => each.wish.kind)).toEqual(["attract", "avoid"]);
    chair.route = { ...chair.route, wishes: [] };
  });

  it("under way takes a wish into its overview, from the map, too, and where places start at once", async () => {
    chair.rider = { ...RIDER, start_at_once: true };
    state({ goal: { x: 9, y: 0, name: "Ward 4" } });
    await trip.via({ name: "Laboratory", x: 4, y: 3 });
    expect(trip.open).toBe(true);
    expect(trip.draft!.wishes.map((each) => each.words)).toEqual(["Go via Laboratory"]);
    expect(goals()).toEqual([]);
    trip.close();
    selection.tool = "not-this-way";
    selection.stroke([[0, 0], [2, 0], [2, 2]]);
    expect(trip.draft!.wishes.map((each) => each.wish.kind)).toEqual(["avoid"]);
  });

  it("does not begin by routes of other wishes", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    const planned = trip.via({ name: "Laboratory", x: 4, y: 3 });
    await trip.start();
    expect(goals()).toEqual([]);
    await planned;
    await trip.start();
    expect(goals()).toHaveLength(1);
  });

  it("is kept when its overview is hidden, and for another place, until it is cancelled or begins", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.via({ name: "Laboratory", x: 4, y: 3 });
    trip.hide();
    expect(trip.open).toBe(false);
    expect(trip.draft).toMatchObject({ name: "Ward 4", wishes: [{ wish: { kind: "attract" } }] });
    await trip.choose({ place: "Ward 2" }, "Ward 2");
    expect(trip.open).toBe(true);
    expect(asked.at(-1)).toMatchObject({ place: "Ward 2", wishes: [{ points: [[4, 3]] }] });
    trip.close();
    expect([trip.draft, trip.open]).toEqual([null, false]);
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect(trip.draft!.wishes).toEqual([]);
    await trip.start();
    expect([trip.draft, trip.open]).toEqual([null, false]);
  });

  it("takes away the announcement of the one before", () => {
    const ward = { x: 9, y: 0, name: "Ward 4" };
    state({ goal: ward });
    chair.heard({ type: "ride_ended", ride: "a", outcome: "arrived", length: 9, duration: 13 } as RideEnded);
    state({ goal: ward });
    expect(chair.ended?.ride).toBe("a");
    expect(chair.endedGoal).toEqual(ward);
    state({ goal: { ...ward, x: 3, name: "Ward 1" } });
    expect(chair.ended).toBeNull();
  });

  it.each([null, { code: "lost", text: "" }])("takes control and confirms where nobody drives, unless %j", async (why) => {
    state({ driver: null, link: "no_driver", not_ready: why });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.start();
    expect(sent).toEqual([{ type: "take_control", confirm: why === null }]);
  });

  it("confirms nothing where nobody drives a trip that is under way", async () => {
    state({ driver: null, link: "no_driver", goal: { x: 9, y: 0, name: "Ward 1" } });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.start();
    expect(sent).toEqual([{ type: "take_control", confirm: false }]);
  });

  it("confirms what the chair waits for now, before the destination, and nothing later", async () => {
    state({ link: "confirm" });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.start();
    expect(sent).toEqual([{ type: "resume" }]);
    state({ link: "confirm" }); // STOP after the press
    trip.look();
    expect(sent).toHaveLength(1);
  });

  it("is planned anew when a wish is added or the chair has gone on", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.via({ name: "Laboratory", x: 2, y: 2 });
    expect(asked).toHaveLength(2);
    state({ pose: [2, 0, 0] });
    trip.look();
    expect(asked).toHaveLength(2);
    state({ pose: [3.5, 0, 0] });
    trip.look();
    expect(asked).toHaveLength(3);
    expect(asked[2]).toMatchObject({ type: "plan_trip", wishes: [{ points: [[2, 2]] }] });
  });

  it("goes to a place on the way, and says by how much it does not get there", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.via({ name: "Laboratory", x: 2, y: 2 });
    await trip.avoid({ name: "Store", x: 5, y: 5 });
    await trip.via({ name: "Pharmacy", x: 3, y: 3 });
    expect(asked.at(-1)).toMatchObject({ wishes: [{ visit: true }, { kind: "avoid" }, { visit: true }] });
    expect([0, 1, 2].map((k) => trip.unkept(k))).toEqual([
      "",
      "cannot be avoided: 3.0 m of the best route lead through it",
      "cannot be reached; passes it at 2.4 m",
    ]);
  });

  it("sets off at once where the therapist allows it", async () => {
    chair.rider = { ...RIDER, start_at_once: true };
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect(goals()).toEqual([{ type: "set_goal", place: "Ward 4", wishes: [], choice: null }]);
  });

  it("shows the wishes on display, and none that was removed", async () => {
    chair.route = { ...chair.route, wishes: [wish("avoid")] };
    state({ goal: { x: 9, y: 0, name: "Ward 4" } });
    expect(trip.shown).toBe(chair.route);
    await trip.change();
    await trip.remove(0);
    await trip.avoid({ name: "Hall", x: 5, y: 5, area: HALL });
    expect(trip.shown.wishes.map(({ points }) => points)).toEqual([HALL]);
    trip.close();
    expect(trip.shown).toBe(chair.route);
    chair.route = { ...chair.route, wishes: [] };
  });

  it("begins by its first route, and gets the alternatives as they come", async () => {
    vi.spyOn(link, "ask").mockResolvedValue({ ...PLANS, routes: [ROUTE], complete: false });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect([trip.startable, trip.routes.length]).toEqual([true, 1]);
    chair.heard({ ...PLANS, id: 9 }); // another one's
    trip.look();
    expect(trip.routes).toHaveLength(1);
    chair.heard(PLANS);
    trip.look();
    expect([trip.draft!.chosen, trip.routes.length]).toEqual([0, 2]);
  });

  it.each(["rider_chosen", "simulation_restarted"])("is of one person: %s ends it", async (code) => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await trip.avoid({ name: "Hall", x: 5, y: 5, area: HALL });
    chair.heard({ type: "notice", code, text: "" });
    trip.look();
    expect([trip.draft, trip.open]).toEqual([null, false]);
  });
});

const HALL: PlaceInfo["area"] = [[0, 4], [9, 4], [9, 6], [0, 6]];

describe("a wish about a place", () => {
  const places: PlaceInfo[] = [{ name: "Hall", x: 5, y: 5, area: HALL, names: {} }, { name: "Desk", x: 2, y: 5, area: [], names: {} }];

  it("to avoid it covers all of it, or says how much where it has no outline", () => {
    const [hall, desk] = places.map(avoidWish);
    expect(hall).toMatchObject({ wish: { points: HALL, radius: 0 }, words: "Avoid Hall" });
    expect(desk).toMatchObject({ wish: { points: [[2, 5]], radius: 1.5 }, words: "Avoid Desk: 1.5 m about it" });
  });

  it("keeps its words while it holds", () => {
    for (const made of [...places.map(avoidWish), ...places.map(viaWish)]) expect(named(made.wish, places)).toEqual(made);
    const area = { kind: "avoid" as const, points: [[2, 5], [3, 5], [3, 6]] as [number, number][], radius: 0, visit: false };
    expect(named(area, places).words).toBe("Avoid this area, by Desk");
    expect(named({ ...area, points: [[90, 5], [93, 5]] }, places).words).toBe("Avoid this area");
  });
});

describe("routes that were not answered for", () => {
  let now = 0;
  let answers = false;
  const questions = (): number => asked.filter((each) => each.type === "plan_trip").length;
  /** Looks ten times a second for so long, s. */
  async function wait(seconds: number): Promise<void> {
    for (const end = now + 1000 * seconds; now < end; now += 100) {
      trip.look();
      await Promise.resolve();
      await Promise.resolve();
    }
  }

  beforeEach(() => {
    [now, answers] = [0, false];
    vi.spyOn(performance, "now").mockImplementation(() => now);
    vi.spyOn(link, "ask").mockImplementation((question) => {
      asked.push(question);
      return Promise.resolve(answers ? PLANS : { type: "rejected", id: 1, code: "no_answer", text: "No answer." });
    });
  });

  it("are asked for again three times by themselves, and then by the rider", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    expect(trip.draft).toMatchObject({ unanswered: true, trouble: "No answer." });
    await wait(1.9);
    expect(questions()).toBe(1);
    await wait(120);
    expect(questions()).toBe(4);
    expect(trip.retries).toBe(false);
    answers = true;
    await trip.again();
    expect(trip.draft).toMatchObject({ unanswered: false, trouble: "" });
    await wait(60);
    expect(questions()).toBe(5);
  });

  it("are asked for once the chair can plan, and not before", async () => {
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    state({ can_plan: false });
    await wait(60);
    expect(questions()).toBe(1);
    answers = true;
    state({ can_plan: true });
    await wait(0.3);
    expect(questions()).toBe(2);
    expect(trip.routes).toHaveLength(2);
    await wait(60);
    expect(questions()).toBe(2);
  });

  it("are not asked for again where the answer was a refusal", async () => {
    vi.spyOn(link, "ask").mockImplementation((question) => {
      asked.push(question);
      return Promise.resolve({ type: "rejected", id: 1, code: "outside_map", text: "This place is outside the map." });
    });
    await trip.choose({ place: "Ward 4" }, "Ward 4");
    await wait(60);
    expect(questions()).toBe(1);
    expect(trip.draft!.unanswered).toBe(false);
  });
});
