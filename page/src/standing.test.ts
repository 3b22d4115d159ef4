import { describe, expect, it } from "vitest";
import { standing, type Stand } from "./standing";

const STATE: NonNullable<Stand["state"]> = {
  link: "ready", driver: "me", goal: null, mode: "shared", paused: false, arrived: false, not_ready: null,
};
const WARD = { name: "Ward 1", x: 0, y: 0 };

function stand(state: Partial<typeof STATE> = {}, more: Partial<Stand> = {}): string {
  return standing({
    state: { ...STATE, ...state },
    audience: "rider", driving: true, why: "", code: "", arrival: null, startable: false, planned: true, error: "",
    ...more,
  });
}

describe("a standing chair says why, in one line", () => {
  it("without a trip, after an arrival, and when it waits for Start", () => {
    expect(stand()).toBe("Standing: no trip");
    expect(stand({}, { arrival: "Ward 1" })).toBe("Arrived: Ward 1");
    expect(stand({}, { arrival: "" })).toBe("Arrived");
    expect(stand({ link: "confirm" }, { arrival: "Ward 1" })).toBe("Arrived: Ward 1"); // the next Start ends the stop
    expect(stand({}, { arrival: "Ward 1", startable: true })).toBe("Ready: press “Start”");
    expect(stand({ driver: null }, { startable: true })).toBe("Ready: press “Start”");
    const nobody = { why: 'Stopped. Tap "Drive from this screen".', code: "no_driver", startable: true };
    expect(stand({ driver: null }, nobody)).toBe("Ready: press “Start”");
    expect(stand({ driver: null })).toBe("Standing: no driver");
    expect(stand({}, { driving: false })).toBe("Standing: another screen drives");
  });

  it("with a reason: the reason, which Start does not hide unless it answers it", () => {
    const why = "A person is crossing. Waiting.";
    expect(stand({ goal: WARD }, { why, code: "waiting" })).toBe(why);
    expect(stand({}, { why: "The scanner cannot see ahead. Stopped.", code: "scan_blind", startable: true })).toBe(
      "The scanner cannot see ahead. Stopped.",
    );
    expect(stand({ link: "confirm" }, { why: "You stopped the chair.", code: "rider_stop" })).toBe("You stopped the chair.");
    expect(stand({ link: "confirm" }, { why: "You stopped the chair.", code: "rider_stop", startable: true })).toBe(
      "Ready: press “Start”",
    );
  });

  it("with a slow computer: not after the arrival", () => {
    const late = { why: "This computer is too slow for real time. Stopped.", code: "navigator_timeout" };
    expect(stand({ goal: WARD }, late)).toBe(late.why);
    expect(stand({}, { ...late, arrival: "Ward 1" })).toBe("Arrived: Ward 1");
  });

  it("names what the rider must do, and to others what they have not done", () => {
    const observer = { audience: "observer", driving: false } as const;
    expect(stand({ link: "confirm" })).toBe("Ready: press “Go on”");
    expect(stand({ link: "confirm" }, observer)).toBe("Standing: the rider has not yet pressed “Go on”");
    expect(stand({ link: "stick_held" })).toBe("Standing: release the stick");
    expect(stand({ link: "stick_held" }, observer)).toBe("Standing: the stick is still held");
    expect(stand({ goal: WARD, mode: "assisted" })).toBe("Ready: steer");
    expect(stand({ goal: WARD, mode: "assisted" }, observer)).toBe("Standing: the rider does not steer");
  });

  it("asks for no press that cannot end the stop", () => {
    const not_ready = { code: "navigator_restarts", text: "The navigator is starting again." };
    const stopped = { why: "You stopped the chair.", code: "rider_stop", startable: true };
    expect(stand({ link: "confirm", not_ready })).toBe("Standing: The navigator is starting again.");
    expect(stand({ link: "confirm", not_ready }, stopped)).toBe("You stopped the chair.");
  });

  it("on the way: the route is missing, or it sets off", () => {
    expect(stand({ goal: WARD }, { planned: false })).toBe("Standing: the route is being planned");
    expect(stand({ goal: WARD }, { error: "No route there is wide enough." })).toBe("Standing: No route there is wide enough.");
    expect(stand({ goal: WARD })).toBe("Setting off");
    expect(stand({ goal: WARD }, { close: "A wall is close." })).toBe("Setting off slowly. A wall is close.");
    expect(stand({ goal: WARD }, { held: "" })).toBe("Standing for a moment");
    expect(stand({ goal: WARD }, { held: "Somebody is in the way." })).toBe("Standing: Somebody is in the way.");
    expect(stand({ goal: WARD, arrived: true })).toBe("Arrived: Ward 1");
  });

  it("is never free to move", () => {
    const links = ["no_driver", "no_heartbeat", "stick_held", "centre_stick", "confirm", "ready"] as const;
    for (const audience of ["rider", "observer"] as const) {
      for (const link of links) expect(stand({ link }, { audience })).not.toBe("");
    }
  });
});
