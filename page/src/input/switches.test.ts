import { describe, expect, it } from "vitest";
import type { ChairState } from "../messages";
import {
  isFollowing, isOver, keepSwitches, keptSwitches, keyName, MAX_BOUNCE, mayBeSwitch, meaning, NO_SWITCH, pushed,
} from "./switches";

const STANDING: ChairState = {
  type: "state", seq: 0, time: 0, pose: [0, 0, 0], speed: 0, turn_rate: 0, command: [0, 0],
  mode: "shared", pace: "normal", rider_authority: 0, link: "ready", heartbeat: -1, driver: "me", device: "none",
  reason: null, not_ready: null, can_plan: true, preparing: null, arrived: false, paused: false, goal: null, remaining: null, route_version: 0, ride: "",
  plan: [], free: [], people: [], groups: [], offers: [], true_people: [], closed_doors: [], lateness: 0, rate: 1,
  unstored: "", clock: 0,
};
const GOAL = { name: "Ward A", x: 1, y: 2 };
const PUSH = { direction: "forward", since: 0 } as const;

describe("switches", () => {
  it("choose while the chair stands", () => {
    expect(meaning(STANDING, null, true)).toBe("choose");
    expect(meaning(null, null, false)).toBe("choose");
  });

  it("stop it whenever it moves, forward, back or round, whoever drives", () => {
    for (const moving of [{ speed: 0.2 }, { speed: -0.2 }, { turn_rate: 0.3 }]) {
      expect(meaning({ ...STANDING, ...moving }, null, true)).toBe("stop");
      expect(meaning({ ...STANDING, ...moving }, null, false)).toBe("stop");
    }
  });

  it("stop it too while it stands but may set off by itself", () => {
    const waiting = { ...STANDING, goal: GOAL };
    expect(meaning(waiting, null, true)).toBe("stop");
    expect(meaning({ ...waiting, mode: "autonomous" }, null, true)).toBe("stop");
    for (const not of [
      { mode: "assisted" }, { mode: "manual" }, { arrived: true }, { link: "confirm" }, { paused: true },
    ] as const) {
      expect(isFollowing({ ...waiting, ...not })).toBe(false);
      expect(meaning({ ...waiting, ...not }, null, true)).toBe("choose");
    }
  });

  it("let go where only the switch moves it, and stop it where it follows its way besides", () => {
    expect(meaning({ ...STANDING, speed: 0.4 }, PUSH, true)).toBe("let-go");
    expect(meaning({ ...STANDING, speed: 0.4, goal: GOAL }, PUSH, true)).toBe("stop");
  });

  it("do not drive on for ever", () => {
    expect(pushed(PUSH, 14_999).forward).toBeGreaterThan(0);
    expect(isOver(PUSH, 15_000)).toBe(true);
    expect(pushed(PUSH, 15_000)).toEqual({ forward: 0, left: 0 });
    expect(pushed(null, 0)).toEqual({ forward: 0, left: 0 });
  });

  it("are kept, and what does not read is as if there were none", () => {
    const kept = new Map<string, string>();
    const storage = () => ({
      getItem: (key: string) => kept.get(key) ?? null,
      setItem: (key: string, value: string) => void kept.set(key, value),
    });
    expect(keptSwitches(storage)).toEqual(NO_SWITCH);
    const two = { count: 2, hold: true, choose: "F1", step: "F2", bounce: 150 } as const;
    keepSwitches(two, storage);
    expect(keptSwitches(storage)).toEqual(two);
    for (const odd of ["{", "null", '{"count": 3, "choose": "Escape", "step": 4, "bounce": "9"}']) {
      expect(keptSwitches(() => ({ getItem: () => odd }))).toEqual(NO_SWITCH);
    }
    for (const [kept, bounce] of [[-1, 0], [9e9, MAX_BOUNCE], [70, 70]]) {
      expect(keptSwitches(() => ({ getItem: () => `{"bounce": ${kept}}` })).bounce).toBe(bounce);
    }
    const forbidden = () => {
      throw new Error("no storage here");
    };
    expect(keptSwitches(forbidden)).toEqual(NO_SWITCH);
    expect(() => keepSwitches(two, forbidden)).not.toThrow();
  });

  it("never take the key that stops", () => {
    expect(["Escape", "Tab", "ShiftLeft", ""].some(mayBeSwitch)).toBe(false);
    expect(["Space", "F7", "KeyM", "ArrowUp"].every(mayBeSwitch)).toBe(true);
    expect(["KeyM", "ArrowUp", "F7", "Space"].map(keyName)).toEqual(["M", "Arrow Up", "F7", "Space"]);
  });
});
