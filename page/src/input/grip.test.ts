import { describe, expect, it } from "vitest";
import { dragged, gripped, lifted, pull } from "./grip";

describe("grip", () => {
  it("does not move the chair by a touch alone, wherever it lands", () => {
    expect(pull(gripped(null, 1, 37, 99), 50)).toEqual({ forward: 0, left: 0 });
  });

  it("is pulled from where it was touched, up to full", () => {
    const grip = gripped(null, 1, 100, 100);
    // 25 px up and 10 px right of 50 px
    expect(pull(dragged(grip, 1, 110, 75), 50)).toEqual({ forward: 0.5, left: -0.2 });
    expect(pull(dragged(grip, 1, 100, -900), 50).forward).toBe(1);
  });

  it("belongs to the first finger; others neither move nor free it", () => {
    const grip = dragged(gripped(null, 1, 0, 0), 1, 0, -10);
    expect(gripped(grip, 2, 50, 50)).toBe(grip);
    expect(dragged(grip, 2, 50, 50)).toBe(grip);
    expect(lifted(grip, 2)).toBe(grip);
    expect(lifted(grip, 1)).toBeNull();
  });

  it("springs back", () => {
    expect(pull(null, 50)).toEqual({ forward: 0, left: 0 });
    expect(pull(gripped(null, 1, 0, 0), 0)).toEqual({ forward: 0, left: 0 });
  });
});
