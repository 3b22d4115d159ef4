// @vitest-environment node
import { describe, expect, it } from "vitest";
import { SILENT, told, type ReasonDisplay } from "./reasonDisplay";

const close = { code: "too_close", text: "Too close." };
const blocked = { code: "blocked", text: "Blocked." };

/** One reason, twenty times a second from one time to another, ms. */
function lasting(was: ReasonDisplay, why: typeof close | null, from: number, to: number): ReasonDisplay {
  let saying = was;
  for (let now = from; now <= to; now += 50) saying = told(saying, why, now);
  return saying;
}

describe("a reason", () => {
  it("is shown at once and spoken when it lasts", () => {
    const first = told(SILENT, close, 0);
    expect(first.shown).toEqual(close);
    expect(first.spoken).toBe("");
    expect(lasting(first, close, 50, 700).spoken).toBe("Too close.");
  });

  it("that is gone at once is not spoken, yet can be read", () => {
    const gone = lasting(told(SILENT, close, 0), null, 50, 1_400);
    expect(gone.spoken).toBe("");
    expect(gone.shown).toEqual(close);
    expect(lasting(gone, null, 1_450, 1_600).shown).toBeNull();
  });

  it("leaves nothing behind to be read once it is gone", () => {
    const once = lasting(SILENT, close, 0, 1_000);
    expect(lasting(once, null, 1_050, 1_600).spoken).toBe("");
  });

  it("does not flicker with another one", () => {
    let saying = SILENT;
    const shown = new Set<string | undefined>();
    for (let k = 0; k < 20; k++) {
      saying = told(saying, k % 2 ? close : blocked, 50 * k);
      shown.add(saying.shown?.code);
    }
    expect([...shown]).toEqual(["blocked"]);
  });

  it("is not spoken again soon", () => {
    const once = lasting(SILENT, close, 0, 1_000);
    const back = lasting(lasting(once, null, 1_050, 4_000), close, 4_050, 6_000);
    expect(back.lastAt).toBe(once.lastAt);
    const later = lasting(lasting(back, null, 6_050, 20_000), close, 20_050, 21_500);
    expect(later.lastAt).toBeGreaterThan(20_000);
  });
});
