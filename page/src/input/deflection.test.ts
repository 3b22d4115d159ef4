import { describe, expect, it } from "vitest";
import { CENTRE, deflection, isCentred, size } from "./deflection";

describe("deflection", () => {
  it("stays within the unit circle and keeps its direction", () => {
    const d = deflection(1, -1);
    expect(size(d)).toBeCloseTo(1);
    expect(d.forward).toBeCloseTo(Math.SQRT1_2);
    expect(d.left).toBeCloseTo(-Math.SQRT1_2);
  });

  it("takes what is no number for the centre", () => {
    expect(deflection(NaN, Infinity)).toEqual(CENTRE);
    expect(Object.is(deflection(-0, 0).forward, 0)).toBe(true);
  });

  it("counts the dead zone's edge as centred, in every direction alike", () => {
    for (let angle = 0; angle < 6.3; angle += 0.1) {
      const at = (r: number) => deflection(r * Math.cos(angle), r * Math.sin(angle));
      expect(isCentred(at(0.0999), 0.1)).toBe(true);
      expect(isCentred(at(0.1001), 0.1)).toBe(false);
    }
  });
});
