import { beforeEach, describe, expect, it } from "vitest";
import { plotOf, QUANTITIES, WIDTH } from "./progress";
import { goalFault, isWhole, nameFault, tooLong } from "./riderForm";
import { Riders, type Direction, type RiderDraft, type RiderProgress } from "./riders.svelte";

const LIMITS = { max_speed: 0.5, max_acceleration: 0.4, min_distance: 0.8 };
const DRAFT: RiderDraft = {
  name: "Ana", notes: "", goals: [],
  preset: {
    limits: LIMITS, mode: "shared", pace: "slow",
    settings: { tremor_filter: 0, dead_zone: 0.1, dwell: 1, start_at_once: false, switches: null },
  },
};

function progressOf(values: (number | null)[], direction: Direction): RiderProgress {
  return {
    sessions: values.map((value, k) => ({
      session: String(k), started: "", scene: "", rides: 1, trips: 1, arrivals: 1, unaided: 0, distance: 9, mode: "shared",
      values: Object.fromEntries(QUANTITIES.map((name) => [name, value])) as RiderProgress["sessions"][0]["values"],
    })),
    directions: Object.fromEntries(QUANTITIES.map((name) => [name, direction])) as RiderProgress["directions"],
    goals: [],
    min_sessions: 6,
  };
}

describe("a rider's form", () => {
  it("takes what the server takes", () => {
    expect(isWhole(DRAFT, ["Bo"])).toBe(true);
    expect(isWhole({ ...DRAFT, name: "  " }, [])).toBe(false);
    expect(isWhole({ ...DRAFT, name: "\u200b" }, [])).toBe(false); // nothing that is seen
    expect(isWhole({ ...DRAFT, name: "x".repeat(81) }, [])).toBe(false);
    expect(isWhole({ ...DRAFT, notes: "x".repeat(2001) }, [])).toBe(false);
    expect(isWhole({ ...DRAFT, preset: { ...DRAFT.preset, limits: { ...LIMITS, max_speed: NaN } } }, [])).toBe(false);
    expect(isWhole({ ...DRAFT, goals: [{ kind: "words", target: 1, text: " ", done: false }] }, [])).toBe(false);
  });

  it("knows a name again in another case and with other spaces", () => {
    expect(nameFault(" ana  b", ["Ana B"])).toBe("Another rider has this name or number.");
    expect(nameFault("Ana C", ["Ana B"])).toBe("");
  });

  it("counts characters as people do, and trips as whole numbers", () => {
    expect(tooLong("🙂".repeat(80), 80)).toBe("");
    expect(tooLong("🙂".repeat(81), 80)).toBe("At most 80 characters; now 81.");
    expect(goalFault({ kind: "arrivals", target: 1.5, text: "", done: false })).not.toBe("");
    expect(goalFault({ kind: "arrivals", target: 1000, text: "", done: false })).toBe("");
  });
});

describe("a plot", () => {
  it("has a dot for each value, where its session is, and no line where there are few", () => {
    const plot = plotOf("stops", progressOf([4, null, 2], "few"));
    expect(plot.dots).toEqual([{ x: 6, y: 6, compared: true }, { x: WIDTH - 6, y: 32, compared: true }]); // 4 of 4 at the top; 2 of 4 half-way down
    expect(plot.joined).toBe(false);
    expect(plot.words).toBe(
      "Stops, on 100 m: from 4.0 in the first to 2.0 in the latest of 2 sessions, between 2.0 and 4.0. " +
        "2 of the 6 sessions in this mode that are needed to tell a direction.",
    );
  });

  it("compares the sessions in the mode of the latest one", () => {
    const progress = progressOf([1, 2, 3], "few");
    progress.sessions[0]!.mode = "manual";
    const plot = plotOf("effort", progress);
    expect(plot.dots.map((dot) => dot.compared)).toEqual([false, true, true]);
    expect(plot.direction).toBe("2 of the 6 sessions in this mode that are needed to tell a direction.");
  });

  it("of a share reaches from nothing to the whole", () => {
    const plot = plotOf("arrivals", progressOf([0.5], "few"));
    expect(plot.dots).toEqual([{ x: WIDTH / 2, y: 32, compared: true }]);
    expect([plot.top, plot.latest]).toEqual(["100", "last value 50"]);
    expect(plotOf("effort", progressOf([null], "few")).dots).toEqual([]);
  });
});

describe("riders", () => {
  let riders: Riders;
  beforeEach(() => (riders = new Riders()));

  it("have a name by their id, and one that cannot be read has that", () => {
    const record = { ...DRAFT, id: "rider-1", created: "", changed: "" };
    riders.take({ ok: true, value: { riders: [record], damaged: [], current: "rider-1" } });
    expect([riders.name(""), riders.name("rider-1"), riders.name("rider-2")]).toEqual(["", "Ana", "rider-2 (cannot be read)"]);
    expect(riders.current?.name).toBe("Ana");
    riders.take({ ok: false, status: 403, text: "No." });
    expect([riders.trouble, riders.name("rider-1")]).toEqual(["No.", "Ana"]);
  });
});
