import { describe, expect, it } from "vitest";
import { begun, litOf, RESTING, selected, stepped, ticked, type Choice, type Scan } from "./scan";

const ALL: Choice[] = [
  { key: "f", label: "Forward" },
  { key: "l", label: "Left" },
  { key: "p", label: "Places", items: [{ key: "a", label: "Ward A" }, { key: "b", label: "Ward B" }] },
];
const PACE = { dwell: 1000 };

/** Highlighted item at each of these times, ms, without a press. */
function lit(scan: Scan, times: number[]): (string | null)[] {
  return times.map((time) => (scan = ticked(scan, ALL, PACE, time)).lit);
}

describe("scan", () => {
  it("rests until it is asked", () => {
    expect(ticked(RESTING, ALL, PACE, 99_999)).toBe(RESTING);
    expect(selected(RESTING, ALL, 0, 0)).toMatchObject({ scan: { lit: "f" }, chosen: null });
  });

  it("dwells on each choice and comes round", () => {
    expect(lit(begun(ALL, 0), [999, 1000, 1999, 2000, 3000])).toEqual(["f", "l", "l", "p", "f"]);
  });

  it("pauses after a choice", () => {
    const { scan, chosen } = selected({ ...begun(ALL, 0), lit: "l" }, ALL, 5000, 1000);
    expect(chosen?.label).toBe("Left");
    expect(lit(scan, [6000, 6999, 7000])).toEqual(["f", "f", "l"]);
  });

  it("opens a group, chooses in it, and goes back", () => {
    const inside = selected({ ...begun(ALL, 0), lit: "p" }, ALL, 0, 0).scan;
    expect(litOf(inside, ALL)?.label).toBe("Ward A");
    expect(selected(stepped(inside, ALL, 1), ALL, 2, 0).chosen?.label).toBe("Ward B");
    const back = stepped(stepped(inside, ALL, 1), ALL, 2);
    expect(litOf(back, ALL)?.label).toBe("Back");
    expect(selected(back, ALL, 3, 0)).toMatchObject({ scan: { path: [], lit: "f" }, chosen: null });
  });

  it("opens groups in groups, and goes back one at a time", () => {
    const deep: Choice[] = [{ key: "o", label: "Outer", items: [{ key: "i", label: "Inner", items: ALL }, ...ALL] }];
    const outer = selected(begun(deep, 0), deep, 0, 0).scan;
    const inner = selected(outer, deep, 0, 0).scan;
    expect(inner).toMatchObject({ path: ["o", "i"], lit: "f" });
    const back = selected({ ...inner, lit: "back" }, deep, 0, 0).scan;
    expect(back).toMatchObject({ path: ["o"], lit: "i" });
    expect(selected({ ...back, lit: "back" }, deep, 0, 0).scan).toMatchObject({ path: [], lit: "o" });
  });

  it("closes a group after two rounds in vain, and rests after five", () => {
    const inside = selected({ ...begun(ALL, 0), lit: "p" }, ALL, 0, 0).scan;
    // three choices a round: after 6 s both rounds are over
    expect(lit(inside, [1000, 2000, 3000, 4000, 5000, 6000])).toEqual(["b", "back", "a", "b", "back", "f"]);
    let scan = begun(ALL, 0);
    for (let time = 1000; time <= 15_000; time += 1000) scan = ticked(scan, ALL, PACE, time);
    expect(scan).toBe(RESTING);
  });

  it("with two switches waits as long as it takes, and never rests", () => {
    let scan = begun(ALL, 0);
    for (let k = 0; k < 30; k++) scan = stepped(scan, ALL, k);
    expect(scan.lit).toBe("f");
  });

  it("begins again where what was lit is gone", () => {
    const lost = { ...begun(ALL, 0), lit: "gone" };
    expect(litOf(lost, ALL)?.key).toBe("f");
    expect(stepped(lost, ALL, 1).lit).toBe("f");
    expect(litOf({ ...lost, path: ["gone too"] }, ALL)?.key).toBe("f");
    expect(litOf(lost, [])).toBeNull();
    expect(selected(begun([], 0), [], 0, 0).chosen).toBeNull();
  });
});
