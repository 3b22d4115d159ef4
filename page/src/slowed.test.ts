import { describe, expect, it } from "vitest";
import type { Cause } from "./around";
import { slowForPerson } from "./slowed";

const STATE = {
  pose: [0, 0, 0] as const, goal: { name: "Ward 1", x: 9, y: 0 }, remaining: 9, speed: 0.2, turn_rate: 0, pace: "normal" as const,
  rider_authority: 0,
};
const PERSON: Cause = { thing: "person", at: [2, 0] };

describe("a chair is slow for a person", () => {
  it("who is near and ahead, while it drives below half its pace", () => {
    expect(slowForPerson(STATE, PERSON, 1)).toBe(true);
    expect(slowForPerson({ ...STATE, speed: 0.6 }, PERSON, 1)).toBe(false);
    expect(slowForPerson(STATE, { ...PERSON, at: [3, 0] }, 1)).toBe(false);
    expect(slowForPerson(STATE, { ...PERSON, thing: "wall" }, 1)).toBe(false);
    expect(slowForPerson(STATE, null, 1)).toBe(false);
  });

  it("not where a limit, a turn or the destination slows it, nor while it stands", () => {
    expect(slowForPerson({ ...STATE, speed: 0.25 }, PERSON, 0.3)).toBe(false);
    expect(slowForPerson({ ...STATE, turn_rate: -0.6 }, PERSON, 1)).toBe(false);
    expect(slowForPerson({ ...STATE, remaining: 1 }, PERSON, 1)).toBe(false);
    expect(slowForPerson({ ...STATE, rider_authority: 0.8 }, PERSON, 1)).toBe(false);
    expect(slowForPerson({ ...STATE, goal: null }, PERSON, 1)).toBe(false);
    expect(slowForPerson({ ...STATE, speed: 0 }, PERSON, 1)).toBe(false);
  });
});
