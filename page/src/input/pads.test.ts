import { describe, expect, it } from "vitest";
import { connectedPads, newlyPressed, padButtons, padDeflection, type Pad } from "./pads";

function pad(axes: number[], down: number[] = [], mapping = "standard"): Pad {
  const buttons = Array.from({ length: 17 }, (_, n) => ({ pressed: down.includes(n) }));
  return { index: 0, connected: true, mapping, axes, buttons };
}

describe("pads", () => {
  it("turn the axes, which point right and down", () => {
    expect(padDeflection(pad([0.5, -0.8]))).toEqual({ forward: 0.8, left: -0.5 });
  });

  it("rest where axes are missing or no numbers", () => {
    expect(padDeflection(pad([]))).toEqual({ forward: 0, left: 0 });
    expect(padDeflection(pad([NaN, 7])).forward).toBe(-1);
  });

  it("heed the cross before the stick", () => {
    expect(padDeflection(pad([0, 0], [12]))).toEqual({ forward: 0.6, left: 0 });
    expect(padDeflection(pad([0, 0], [12, 13]))).toEqual({ forward: 0, left: 0 });
  });

  it("stop by any of the large buttons, and by any at all where the device is not known", () => {
    expect([0, 1, 2, 3].every((n) => padButtons(pad([], [n])).stop)).toBe(true);
    expect(padButtons(pad([], [9]))).toEqual({ stop: false, resume: true });
    expect(padButtons(pad([], [9], ""))).toEqual({ stop: true, resume: false });
  });

  it("tell a press once; one that is held as it comes may stop, never go on", () => {
    expect(newlyPressed(pad([], [0, 9]), undefined)).toEqual({ stop: true, resume: false });
    const held = padButtons(pad([], [0, 9]));
    expect(newlyPressed(pad([], [0, 9]), held)).toEqual({ stop: false, resume: false });
    expect(newlyPressed(pad([], [9]), padButtons(pad([])))).toEqual({ stop: false, resume: true });
  });

  it("are none where the browser forbids or lacks them", () => {
    const refuse = () => {
      throw new Error("no");
    };
    expect(connectedPads({ getGamepads: refuse })).toEqual([]);
    expect(connectedPads({ getGamepads: () => [null] })).toEqual([]);
  });
});
