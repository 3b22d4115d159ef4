import { describe, expect, it } from "vitest";
import {
  connectedPads, isFrozen, newlyPressed, padDeflection, padReading, withStartDown, type Pad, type PadReading,
} from "./pads";

function pad(axes: number[], down: number[] = [], mapping = "standard", timestamp = 0): Pad {
  const buttons = Array.from({ length: 17 }, (_, n) => ({ pressed: down.includes(n), value: 0 }));
  return { index: 0, connected: true, mapping, timestamp, axes, buttons };
}
/** The last reading, of buttons that were held. */
const held = (...down: number[]) => padReading(pad([], down), undefined, 0);

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
    expect([0, 1, 2, 3].every((n) => newlyPressed(pad([], [n]), held()).stop)).toBe(true);
    expect(newlyPressed(pad([], [9]), held())).toEqual({ stop: false, resume: true });
    expect(newlyPressed(pad([], [9], ""), held())).toEqual({ stop: true, resume: false });
  });

  it("tell a press once; one that is held as it comes may stop, never go on", () => {
    expect(newlyPressed(pad([], [0, 9]), undefined)).toEqual({ stop: true, resume: false });
    expect(newlyPressed(pad([], [0, 9]), held(0, 9))).toEqual({ stop: false, resume: false });
    expect(newlyPressed(pad([], [9]), padReading(pad([]), undefined, 0))).toEqual({ stop: false, resume: true });
    expect(newlyPressed(pad([], [9]), withStartDown(held()))).toEqual({ stop: false, resume: false });
    const few = { ...pad([]), buttons: [] };
    expect(newlyPressed(pad([], [1, 9]), padReading(few, undefined, 0))).toEqual({ stop: true, resume: false });
  });

  it("have an edge for each button: no stuck one masks STOP, whatever the mapping", () => {
    for (const mapping of ["standard", "", "xr-standard"]) {
      for (const stuck of [0, 1, 2, 3, 5, 9]) {
        for (const stop of [0, 1, 2, 3].filter((n) => n !== stuck)) {
          expect(newlyPressed(pad([], [stuck, stop], mapping), held(stuck)).stop).toBe(true);
          expect(newlyPressed(pad([], [stuck, stop], mapping), held(stuck, stop)).stop).toBe(false);
        }
      }
    }
  });

  it("are none where the browser forbids or lacks them", () => {
    const refuse = () => {
      throw new Error("no");
    };
    expect(connectedPads({ getGamepads: refuse })).toEqual([]);
    expect(connectedPads({ getGamepads: () => [null] })).toEqual([]);
  });
});

describe("a gamepad that looks dead", () => {
  /** First time at which it does, s; polled for a minute, and read into one object, as in some browsers. */
  function frozenAfter(at: (time: number) => { axes: number[]; down?: number[]; timestamp?: number }): number {
    const live = { ...pad([]) } as { -readonly [K in keyof Pad]: Pad[K] };
    const axes: number[] = [];
    let was: PadReading | undefined;
    for (let now = 0; now < 60_000; now += 20) {
      const { axes: values, down = [], timestamp = 0 } = at(now);
      axes.splice(0, axes.length, ...values);
      Object.assign(live, pad(axes, down, "standard", timestamp));
      was = padReading(live, was, now);
      if (isFrozen(live, was, now)) return now / 1000;
    }
    return Infinity;
  }

  it.each([
    ["an analogue stick", { axes: [0.12, -0.8] }, 5.02],
    ["one that is full in one axis only", { axes: [0.12, -1] }, 5.02],
    ["a stick at its stop", { axes: [0, -1] }, 15.02],
    ["a digital stick of 8 bits", { axes: [-0.0039, 1] }, 15.02],
    ["the cross, beside a stick off its centre", { axes: [0.02, 0.02], down: [12] }, 15.02],
  ])("repeats its last state: %s", (_, last, seconds) => {
    expect(frozenAfter(() => last)).toBe(seconds);
  });

  it("sends new times with an old deflection", () => {
    expect(frozenAfter((now) => ({ axes: [0.12, -0.8], timestamp: now }))).toBe(15.02);
  });

  it.each([
    ["noise of the stick", (now: number) => ({ axes: [0.12, -0.8 + (Math.floor(now / 4000) % 2) / 128] })],
    ["noise of another axis", (now: number) => ({ axes: [0, -1, 0, (Math.floor(now / 4000) % 2) / 128] })],
    ["a button now and then", (now: number) => ({ axes: [0, -1], down: now % 10_000 < 200 ? [5] : [] })],
  ])("is none with %s", (_, at) => {
    expect(frozenAfter(at)).toBe(Infinity);
  });
});
