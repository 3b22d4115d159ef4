// @vitest-environment node
import { describe, expect, it } from "vitest";
import { compared, detour, memorable, metres, minutes, movement, observed, readiness, reasonWords, startWords, wishesCost } from "./words";

const state = { link: "ready", driver: "a", goal: null, mode: "shared", arrived: false, reason: null, not_ready: null } as const;

describe("the difference of a route", () => {
  const ways = { name: "North corridor", x: 5, y: 5, area: [[0, 4], [10, 4], [10, 6], [0, 6]] as [number, number][], names: {} };
  const first = { points: [[0, 0], [5, 0], [10, 0]] as [number, number][], duration: 40, differences: [] };
  const north = { ...first, points: [[0, 0], [0, 5], [10, 5], [10, 0]] as [number, number][], duration: 52 };

  it("is told by where it leads, by time, and by what else is noticed", () => {
    const differences = [{ what: "length", more: 10 }, { what: "encounters", more: -2 }, { what: "turns", more: 1 }] as const;
    expect(compared({ ...north, differences: [...differences] }, first, [ways])).toBe(
      "through North corridor, about 10 s longer, fewer people, 1 more turn",
    );
    expect(compared({ ...north, duration: 190 }, first, [])).toBe("about 3 min longer");
    // "about 50 s" and "about 60 s" differ by what one reads, not by 14.
    expect(compared({ ...north, duration: 62 }, { ...first, duration: 48 }, [])).toBe("about 10 s longer");
  });

  it("is its length where nothing else is noticed, or nothing", () => {
    const near = { ...first, points: [[0, 0.1], [10, 0.1]] as [number, number][] };
    expect(compared({ ...near, differences: [{ what: "length", more: 2.4 }] }, first, [ways])).toBe("2 m longer");
    expect(compared(near, first, [ways])).toBe("nearly equal");
  });
});

describe("the reason on display", () => {
  it("word a reason for who reads it", () => {
    const stop = { code: "rider_stop", text: 'You stopped the chair. Tap "Go on".' };
    expect(reasonWords(stop, null, 1, "observer")).toBe("STOP was pressed.");
    const ask = { code: "ask_rider", text: "No way through. Please steer, or choose another destination." };
    expect(reasonWords(ask, null, 1, "observer")).toBe("No way through. The rider must steer, or choose another destination.");
    const waiting = { code: "waiting", text: "Waiting until the way is clear." };
    const person = { thing: "person", at: [0, 0], moves: "crossing" } as const;
    expect(reasonWords(waiting, person, 1)).toBe("A person is crossing. Waiting.");
    expect(reasonWords(waiting, person, 1, "observer")).toBe("A person is crossing in front of the chair. Waiting.");
    expect(observed(waiting)).toBe(waiting.text);
  });

  it("leaves what the rider must do to the button that does it", () => {
    const reason = { code: "rider_stop", text: 'You stopped the chair. Tap "Go on".' };
    expect(reasonWords(reason, null, 1)).toBe("You stopped the chair.");
    expect(reasonWords({ code: "confirm", text: 'Tap "Go on".' }, null, 1)).toBe('Tap "Go on".');
  });
});

describe("what the driver has to do", () => {
  it("is to take control where nobody or somebody else drives", () => {
    expect(readiness({ ...state, driver: null, link: "no_driver" }, false).action).toBe("take_control");
    expect(readiness(state, false)).toMatchObject({ action: "take_control", label: "Drive from this screen" });
  });

  it("is to let go before anything can be confirmed", () => {
    for (const link of ["stick_held", "centre_stick", "no_heartbeat"] as const) {
      expect(readiness({ ...state, link }, true).action).toBeNull();
    }
    expect(readiness({ ...state, link: "confirm" }, true).action).toBe("resume");
  });

  it("is no button while the chair moves on by itself once the stick is released", () => {
    const held = { ...state, link: "centre_stick", goal: { name: "Ward 4", x: 0, y: 0 } } as const;
    expect(readiness(held, true)).toMatchObject({ label: "", text: "The chair moves on when you release the stick." });
    expect(readiness({ ...held, goal: null }, true).text).toBe("Release the stick, then steer.");
    expect(readiness({ ...held, mode: "assisted" }, true).text).toBe("Release the stick, then steer.");
    expect(readiness({ ...held, link: "stick_held" }, true)).toMatchObject({
      label: "Go on to Ward 4", text: "Stopped. Release the stick, then tap “Go on”.",
    });
  });

  it("is no confirmation while that cannot end the stop: the button says why, and what to do", () => {
    const held = (code: string, text: string) =>
      readiness({ ...state, link: "confirm", not_ready: { code, text } }, true);
    const restarts = held("navigator_restarts", "The navigator is starting again.");
    expect(restarts).toMatchObject({ action: null, label: "Go on" });
    expect(restarts.text).toBe("The navigator is starting again. You can go on in a moment.");
    expect(held("scan_blind", "The scanner cannot see ahead. Stopped.").text).toBe(
      "The scanner cannot see ahead. If it lasts, ask for help.",
    );
  });

  it("is nothing without a link", () => {
    expect(readiness(null, false).action).toBeNull();
  });

  it("is to choose where to go, else it says where we go", () => {
    expect(readiness(state, true).text).toBe("Steer, or choose a destination.");
    const goal = { name: "Ward 4", x: 0, y: 0 };
    expect(readiness({ ...state, goal }, true).text).toBe("Destination: Ward 4.");
    expect(readiness({ ...state, goal }, true, { trouble: "no way" }).text).toBe("No route to Ward 4. Choose another destination.");
  });
});

describe("the button below", () => {
  const goal = { name: "Ward 4", x: 0, y: 0 };
  const stopped = { ...state, link: "confirm" } as const;

  it("is away while the link is ready: there is nothing to press", () => {
    for (const each of [state, { ...state, goal }, { ...state, reason: { code: "starting", text: "" } }]) {
      expect(readiness(each, true)).toMatchObject({ action: null, label: "" });
    }
  });

  it("says where it goes on to", () => {
    expect(readiness({ ...stopped, goal }, true)).toMatchObject({ action: "resume", label: "Go on to Ward 4", main: true });
    expect(readiness(stopped, true)).toMatchObject({ action: "resume", label: "Go on", main: true });
    expect(readiness({ ...stopped, goal, arrived: true }, true).label).toBe("Go on");
  });

  it("is Start while a trip is chosen: that ends the stop, too", () => {
    const start = { words: "Start this trip", ready: true };
    const text = "Stopped. Tap “Start this trip” to set off.";
    const button = { action: "start", label: "Start this trip", main: true };
    expect(readiness({ ...stopped, goal }, true, { start })).toEqual({ ...button, text });
    expect(readiness({ ...state, driver: null, link: "no_driver" }, false, { start })).toMatchObject(button);
    expect(readiness(stopped, true, { start: { ...start, ready: false } })).toEqual({ ...button, action: null, text: "Stopped." });
    expect(readiness(state, false, { start })).toMatchObject({ action: "take_control", label: "Drive from this screen" });
  });

  it("is not the main one after an arrival", () => {
    expect(readiness(stopped, true, { arrived: true })).toMatchObject({
      action: "resume", main: false, text: "Choose a destination, or tap “Go on” to steer.",
    });
    expect(readiness({ ...stopped, goal }, true, { arrived: true }).main).toBe(true);
  });

  it("stands below a text that promises no way while a fault holds the chair", () => {
    expect(readiness({ ...state, goal }, true, { held: true }).text).toBe("The trip to Ward 4 is on hold.");
  });
});

describe("the button of the overview", () => {
  it("says what a press does to a chair that stands, and to one that drives", () => {
    expect(startWords(false, true)).toBe("Start");
    expect(startWords(true, true)).toBe("Start this trip");
    expect(startWords(true, false)).toBe("Change to this trip");
  });
});

describe("what the wheels do", () => {
  it("is to turn, too", () => {
    expect(movement({ speed: 0, turn_rate: 0 })).toBe("");
    expect(movement({ speed: 0.04, turn_rate: -0.4 })).toBe("turning");
    expect(movement({ speed: 0.52, turn_rate: 0.4 })).toBe("0.5 m/s");
    expect(movement({ speed: -0.3, turn_rate: 0 })).toBe("reverse, 0.3 m/s");
  });
});

describe("a ride that is over", () => {
  it("is asked about unless it was left at once", () => {
    expect(memorable({ outcome: "cancelled", length: 0.1 })).toBe(false);
    expect(memorable({ outcome: "cancelled", length: 8 })).toBe(true);
    expect(memorable({ outcome: "collision", length: 0.1 })).toBe(true);
  });
});

describe("lengths and times", () => {
  it("are as long as they need to be", () => {
    expect(metres(4.24)).toBe("4.2 m");
    expect(metres(38.2)).toBe("38 m");
    expect(minutes(80.4)).toBe("1:20 min");
    expect(minutes(40)).toBe("40 s");
  });

  it("say what a wish costs", () => {
    expect(detour(4.2)).toBe("+4.2 m");
    expect(detour(-1)).toBe("−1.0 m");
    expect(detour(0.02)).toBe("no detour");
  });
});

describe("the price of wishes", () => {
  const lab = { words: "Go via Laboratory", by: "Laboratory" };
  const avoid = { words: "Avoid this area" };

  it("names them while they are few", () => {
    expect(wishesCost([lab], 4.9)).toBe("By way of Laboratory: +4.9 m.");
    expect(wishesCost([lab, { words: "Go via Ward 2", by: "Ward 2" }], 12.3)).toBe("By way of Laboratory, Ward 2: +12 m.");
    expect(wishesCost([avoid], 0)).toBe("Avoid this area: no detour.");
    expect(wishesCost([lab, avoid], 4.9)).toBe("Go via Laboratory, Avoid this area: +4.9 m.");
    expect(wishesCost([lab, avoid, avoid], 4.9)).toBe("With your 3 wishes: +4.9 m.");
  });
});
