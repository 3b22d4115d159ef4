import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { fault, inForce, isLooser, isSame, LIMITS, limitsOf, onChair, RIDER, told, type Quantity } from "./limits";

const NOW = { max_speed: 1, max_acceleration: 0.6, min_distance: 0.45 };

interface Bounded {
  properties: Record<string, { minimum: number; maximum: number }>;
}
const SCHEMA = JSON.parse(readFileSync("../src/cohelm/web/messages.schema.json", "utf8")) as {
  definitions: Record<"Limits" | "RiderSettings", Bounded>;
};

describe("changes", () => {
  it.each([["Limits", LIMITS], ["RiderSettings", RIDER]] as const)(
    "of %s have the bounds of the messages",
    (name, quantities) => {
      const { properties } = SCHEMA.definitions[name];
      const named = (quantities as readonly Quantity<string>[]).map((q) => [q.name, q.least, q.most]);
      const numbers = Object.entries(properties).filter(([, p]) => p.minimum !== undefined);
      const bounded = numbers.map(([key, p]) => [key, p.minimum, p.maximum]);
      expect(named).toEqual(bounded);
    },
  );

  it("are refused outside of them, and where there is no number", () => {
    const [speed] = LIMITS as [Quantity<string>];
    expect([0.1, 1, 3].map((value) => fault(speed, value))).toEqual(["", "", ""]);
    expect(fault(speed, 3.1)).toBe("Between 0.1 and 3 m/s.");
    expect(fault(speed, NaN)).toBe("A number is missing.");
  });

  it("go no further than the chair, and say where it stopped them", () => {
    expect(limitsOf({ max_speed: 1.5, max_acceleration: 3 }).map((q) => q.most)).toEqual([1.5, 2, 2]);
    const preset = { max_speed: 2, max_acceleration: 0.8, min_distance: 1.5 };
    expect(onChair(preset, { max_speed: 1.2, max_acceleration: 0.6 })).toEqual({
      max_speed: 1.2, max_acceleration: 0.6, min_distance: 1.5,
    });
    expect(onChair(preset, undefined)).toEqual(preset);
    expect(limitsOf(undefined)).toEqual(LIMITS);
    expect(told(NOW, NOW)).toBe("Saved.");
    expect(told({ ...NOW, max_acceleration: 2 }, NOW)).toBe("Saved, limited to what the chair can do.");
  });

  it("say of what was changed what is in force", () => {
    const next = { max_speed: 3, min_distance: 0.45 };
    expect(inForce(LIMITS, next, NOW)).toBe("Applied: Maximum speed 1 m/s, Target distance from people 0.45 m.");
    expect(inForce(RIDER, { dead_zone: 0.1 }, { tremor_filter: 0, dead_zone: 0.1, dwell: 1 })).toBe(
      "Applied: Dead zone 0.1.",
    );
  });

  it("know more speed, more acceleration and less distance for looser", () => {
    expect(isLooser(LIMITS, NOW, { ...NOW, max_speed: 1.1 })).toBe(true);
    expect(isLooser(LIMITS, NOW, { ...NOW, max_acceleration: 0.7 })).toBe(true);
    expect(isLooser(LIMITS, NOW, { ...NOW, min_distance: 0.4 })).toBe(true);
    expect(isLooser(LIMITS, NOW, { max_speed: 0.5, max_acceleration: 0.5, min_distance: 0.6 })).toBe(false);
    expect(isSame(LIMITS, NOW, { ...NOW })).toBe(true);
  });
});
