import { describe, expect, it } from "vitest";
import type { Cause } from "./around";
import { paceOf, slowFor } from "./slowed";

const STATE = {
  pose: [0, 0, 0] as const, goal: { name: "Ward 1", x: 9, y: 0 }, remaining: 9, speed: 0.2, turn_rate: 0, pace: "normal" as const,
  rider_authority: 0,
};
const PERSON: Cause = { thing: "person", at: [2, 0] };

describe("a chair that drives below half its pace is slow", () => {
  it("for a person who is near and ahead", () => {
    expect(slowFor(STATE, PERSON, 1)).toBe("person");
    expect(slowFor({ ...STATE, speed: 0.6 }, PERSON, 1)).toBeNull();
    expect(slowFor(STATE, { ...PERSON, at: [3, 0] }, 1)).toBeNull();
    expect(slowFor(STATE, null, 1)).toBeNull();
  });

  it("for a turn, the destination, or little room, of which the first two come before a person", () => {
    expect(slowFor(STATE, { ...PERSON, thing: "wall" }, 1)).toBe("narrow");
    expect(slowFor({ ...STATE, turn_rate: -0.6 }, PERSON, 1)).toBe("turn");
    expect(slowFor({ ...STATE, remaining: 1 }, PERSON, 1)).toBe("destination");
    expect(slowFor(STATE, PERSON, 1, 1)).toBe("turn");
    expect(slowFor(STATE, PERSON, 1, 5)).toBe("person");
    expect(slowFor({ ...STATE, speed: 0.5 }, PERSON, 1, null, 0.75)).toBe("person");
  });

  it("for nothing where a limit, the rider or a stop is why, or where there is no trip", () => {
    expect(slowFor({ ...STATE, speed: 0.25 }, PERSON, 0.3)).toBeNull();
    expect(slowFor({ ...STATE, rider_authority: 0.8 }, PERSON, 1)).toBeNull();
    expect(slowFor({ ...STATE, goal: null }, PERSON, 1)).toBeNull();
    expect(slowFor({ ...STATE, speed: 0 }, PERSON, 1)).toBeNull();
  });

  it("and its pace is no more than the limit", () => {
    expect(paceOf("brisk", 0.5)).toBe(0.5);
    expect(paceOf("slow", 0.5)).toBe(0.4);
  });
});
