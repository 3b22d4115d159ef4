// @vitest-environment node
import { describe, expect, it } from "vitest";
import { felt, holdsTrip, SILENT, told, type ReasonDisplay, type Seen } from "./reasonDisplay";

const close = { code: "too_close", text: "Too close." };
const blocked = { code: "blocked", text: "Blocked." };
const lost = { code: "lost", text: "Lost." };
const STANDS = { speed: 0, command: [0, 0] } as const;
const DRIVES = { speed: 0.7, command: [0.7, 0] } as const;
const CRAWLS = { speed: 0.2, command: [0.2, 0] } as const;

type Why = { code: string; text: string } | null;

/** One reason, twenty times a second from one time to another, ms; the chair stands unless told otherwise. */
function lasting(was: ReasonDisplay, why: Why, from: number, to: number, moves: Omit<Seen, "reason"> = STANDS): ReasonDisplay {
  let saying = was;
  for (let now = from; now <= to; now += 50) saying = told(saying, { ...moves, reason: why }, now);
  return saying;
}

describe("a fault that holds the trip", () => {
  it("is one of health or input, and no waiting, slowing down or arrival", () => {
    for (const code of ["scan_blind", "stale_scan", "stale_rider_command", "drive_fault", "stick_stuck", "lost"]) {
      expect([code, holdsTrip(code, null)]).toEqual([code, true]);
    }
    for (const code of ["", "waiting", "blocked", "rider_stop", "scan_partly_blind", "drive_weak", "arrived", "starting"]) {
      expect([code, holdsTrip(code, null)]).toEqual([code, false]);
    }
    expect(holdsTrip("rider_stop", { code: "navigator_restarts", text: "The navigator is starting again." })).toBe(true);
  });
});

describe("a reason", () => {
  it("of a stop is shown once it lasts, and then spoken", () => {
    expect(lasting(SILENT, blocked, 0, 350).shown).toBeNull();
    expect(lasting(SILENT, blocked, 0, 450).shown).toEqual(blocked);
    expect(lasting(SILENT, blocked, 0, 1_300).spoken).toBe("Blocked.");
  });

  it("that asks for something, or is a fault, is shown at once", () => {
    expect(told(SILENT, { ...DRIVES, reason: lost }, 0).shown).toEqual(lost);
  });

  it("of a stop stays until the next one is shown: no gap between them in which it would set off", () => {
    const waiting = { code: "waiting", text: "Waiting." };
    let saying = lasting(SILENT, blocked, 0, 1_500);
    const codes = new Set<string | undefined>();
    for (let now = 1_550; now <= 3_000; now += 50) {
      // For half a second either comes, then the next alone.
      saying = told(saying, { ...STANDS, reason: now < 2_000 ? (now % 100 ? null : blocked) : waiting }, now);
      codes.add(saying.shown?.code);
    }
    expect([...codes]).toEqual(["blocked", "waiting"]);
  });

  it("that says driving is not told of a chair that stands", () => {
    const creeping = { code: "creeping", text: "Narrow passage. Driving very slowly." };
    expect(felt({ ...STANDS, reason: creeping }, 0.7)).toBeNull();
    expect(felt({ ...CRAWLS, reason: creeping }, 0.7)).toEqual(creeping);
  });

  it("shorter than that is never shown, however often it comes", () => {
    let saying = SILENT;
    for (let k = 0; k < 10; k++) {
      saying = lasting(saying, blocked, 1_000 * k, 1_000 * k + 100);
      saying = lasting(saying, null, 1_000 * k + 150, 1_000 * k + 950);
      expect(saying.shown).toBeNull();
    }
  });

  it("stays at least a second, and is gone soon after it is over", () => {
    const shown = lasting(SILENT, blocked, 0, 450);
    expect(lasting(shown, null, 500, 1_350).shown).toEqual(blocked);
    expect(lasting(shown, null, 500, 2_000).shown).toBeNull();
  });

  it("that says the chair stands goes when it drives, although the chair still sends it", () => {
    const shown = lasting(SILENT, blocked, 0, 3_000);
    expect(shown.shown).toEqual(blocked);
    expect(lasting(shown, blocked, 3_050, 3_600, DRIVES).shown).toBeNull();
  });

  it("does not flicker with another one", () => {
    let saying = SILENT;
    const shown: (string | undefined)[] = [];
    for (let k = 0; k < 200; k++) {
      saying = told(saying, { ...STANDS, reason: k % 2 ? close : blocked }, 50 * k);
      if (shown.at(-1) !== saying.shown?.code) shown.push(saying.shown?.code);
    }
    expect(shown.length).toBeLessThanOrEqual(2);
  });

  it("gives way at once to a more important one", () => {
    const shown = lasting(SILENT, blocked, 0, 500);
    expect(lasting(shown, lost, 550, 550).shown).toEqual(lost);
  });

  it("is not spoken again soon", () => {
    const once = lasting(SILENT, blocked, 0, 2_000);
    const back = lasting(lasting(once, null, 2_050, 5_000), blocked, 5_050, 7_000);
    expect(back.lastAt).toBe(once.lastAt);
    const later = lasting(lasting(back, null, 7_050, 20_000), blocked, 20_050, 21_600);
    expect(later.lastAt).toBeGreaterThan(20_000);
  });
});

describe("a slow-down", () => {
  it("is told only if it is felt", () => {
    expect(felt({ ...DRIVES, reason: close }, 0.8)).toBeNull(); // 0.7 of 0.8 m/s
    expect(felt({ ...CRAWLS, reason: close }, 0.8)).toEqual(close);
    const cruising = lasting(SILENT, null, 0, 2_000, DRIVES);
    expect(lasting(cruising, close, 2_050, 4_000, DRIVES).shown).toBeNull();
    expect(lasting(cruising, close, 2_050, 4_000, CRAWLS).shown).toEqual(close);
  });
});
