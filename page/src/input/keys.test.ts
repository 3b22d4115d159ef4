import { describe, expect, it } from "vitest";
import { isControl, isTyped, keyed, NO_KEYS, pressed, released, steers } from "./keys";

describe("keys", () => {
  it("are the arrows and W, A, S, D", () => {
    expect(["ArrowUp", "KeyW", "KeyA", "ArrowDown"].every(steers)).toBe(true);
    expect(["Space", "Enter", "KeyQ", ""].some(steers)).toBe(false);
  });

  it("grow to full within half a second and fall to nothing at once", () => {
    const held = pressed(NO_KEYS, "ArrowUp", 1000);
    expect(keyed(held, 1000).forward).toBeCloseTo(0.35);
    // half of the ramp: 0.35 + 0.65 / 2
    expect(keyed(held, 1250).forward).toBeCloseTo(0.675);
    expect(keyed(held, 9999).forward).toBe(1);
    expect(keyed(released(held, "ArrowUp"), 9999)).toEqual({ forward: 0, left: 0 });
  });

  it("go on growing where a held key repeats", () => {
    const held = pressed(pressed(NO_KEYS, "KeyW", 0), "KeyW", 400);
    expect(keyed(held, 500).forward).toBe(1);
  });

  it("work several at once", () => {
    const both = pressed(pressed(NO_KEYS, "KeyW", 0), "ArrowLeft", 0);
    const at = keyed(both, 1000);
    expect(at.forward).toBeGreaterThan(0.8);
    expect(at.left).toBeGreaterThan(0.4);
    expect(Math.hypot(at.forward, at.left)).toBeLessThanOrEqual(1 + 1e-12);
  });

  it("cancel where they are opposite", () => {
    const both = pressed(pressed(NO_KEYS, "ArrowLeft", 0), "KeyD", 300);
    expect(keyed(both, 900)).toEqual({ forward: 0, left: 0 });
    expect(keyed(released(both, "ArrowLeft"), 900).left).toBeLessThan(0);
  });

  it("are left to fields, lists and dialogs that have the focus, and Space to buttons", () => {
    document.body.innerHTML = `<input id="a"><select id="b"></select><button id="c"><b id="d">x</b></button>
      <dialog><p id="e"></p></dialog><div id="f"></div><ul role="listbox"><li id="g"></li></ul>`;
    const at = (id: string) => document.getElementById(id);
    expect(["a", "b", "e", "g"].map(at).every(isTyped)).toBe(true);
    expect(["c", "d", "f"].map(at).some(isTyped)).toBe(false);
    expect(["a", "c", "d"].map(at).every(isControl)).toBe(true);
    expect(isControl(at("f"))).toBe(false);
  });
});
