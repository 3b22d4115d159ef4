import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { watchPresence } from "./presence";

let told: boolean[];
let end: () => void;
let shown: "visible" | "hidden";
let focused: boolean;

beforeEach(() => {
  shown = "visible";
  focused = true;
  vi.spyOn(document, "visibilityState", "get").mockImplementation(() => shown);
  vi.spyOn(document, "hasFocus").mockImplementation(() => focused);
  told = [];
  end = watchPresence(window, (present) => told.push(present));
});
afterEach(() => {
  end();
  vi.restoreAllMocks();
  document.body.innerHTML = "";
});

const fire = (target: EventTarget, name: string) => target.dispatchEvent(new Event(name));

describe("presence", () => {
  it("looks at once", () => expect(told).toEqual([true]));

  it("ends when the page is hidden, left, frozen or behind another window", () => {
    for (const [target, name] of [
      [window, "blur"], [window, "pagehide"], [document, "freeze"],
    ] as const) {
      fire(target, name);
      expect(told.at(-1)).toBe(false);
      fire(window, "focus");
      expect(told.at(-1)).toBe(true);
    }
    shown = "hidden";
    fire(document, "visibilitychange");
    expect(told.at(-1)).toBe(false);
  });

  it("does not come back to a page that is hidden or has no focus", () => {
    fire(window, "blur");
    focused = false;
    fire(document, "visibilitychange");
    fire(window, "pageshow");
    expect(told.at(-1)).toBe(false);
  });

  it("takes a touch or a key for proof of a person", () => {
    fire(window, "blur");
    focused = false;
    fire(window, "pointerdown");
    expect(told.at(-1)).toBe(true);
  });

  it("does not count a frame of the page as away, nor focus that wanders on it", () => {
    document.body.innerHTML = `<iframe></iframe><button>x</button>`;
    document.querySelector("button")!.focus();
    document.querySelector("button")!.blur();
    expect(told.at(-1)).toBe(true);
    vi.spyOn(document, "activeElement", "get").mockReturnValue(document.querySelector("iframe"));
    fire(window, "blur");
    expect(told.at(-1)).toBe(true);
    focused = false; // the frame had the focus, and now another window has it
    fire(window, "blur");
    expect(told.at(-1)).toBe(false);
  });

  it("ends", () => {
    end();
    fire(window, "blur");
    expect(told).toEqual([true]);
  });
});
