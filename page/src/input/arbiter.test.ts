import { describe, expect, it } from "vitest";
import { dropped, gone, NOBODY, read, steering, type Arbiter, type Source } from "./arbiter";
import { CENTRE, deflection } from "./deflection";

const ZONE = 0.1;
const AHEAD = deflection(1, 0);
const LEFT = deflection(0, 1);

function after(...readings: [Source, typeof AHEAD][]): Arbiter {
  return readings.reduce((was, [source, at]) => read(was, source, at, ZONE), NOBODY);
}
const heeded = (arbiter: Arbiter) => steering(arbiter, ZONE);

describe("arbiter", () => {
  it("heeds the one that leaves its centre", () => {
    expect(heeded(after(["keys", AHEAD]))).toEqual({ at: AHEAD, device: "keys", waiting: [] });
  });

  it("gives exactly the centre within the dead zone", () => {
    expect(heeded(after(["joystick", deflection(0.09, 0)]))).toEqual({
      at: CENTRE,
      device: "none",
      waiting: [],
    });
  });

  it("does not heed a gamepad until it has been at its centre", () => {
    const held = after(["gamepad:0", AHEAD]);
    expect(heeded(held)).toEqual({ at: CENTRE, device: "none", waiting: ["gamepad:0"] });
    const centred = read(held, "gamepad:0", deflection(0.05, 0), ZONE);
    expect(heeded(read(centred, "gamepad:0", AHEAD, ZONE)).device).toBe("gamepad");
  });

  it("never lets an idle gamepad override keys", () => {
    const idle = after(["gamepad:0", CENTRE], ["keys", AHEAD], ["gamepad:0", deflection(0.04, 0.03)]);
    expect(heeded(idle)).toMatchObject({ at: AHEAD, device: "keys" });
  });

  it("lets nobody take over from a stick that is pulled", () => {
    const both = after(["keys", AHEAD], ["joystick", LEFT]);
    expect(heeded(both)).toEqual({ at: AHEAD, device: "keys", waiting: ["joystick"] });
  });

  it("makes one that came out of turn go to its centre first", () => {
    const freed = read(after(["keys", AHEAD], ["joystick", LEFT]), "keys", CENTRE, ZONE);
    expect(heeded(read(freed, "joystick", LEFT, ZONE)).at).toBe(CENTRE);
    const centred = read(freed, "joystick", CENTRE, ZONE);
    expect(heeded(read(centred, "joystick", LEFT, ZONE))).toMatchObject({ at: LEFT, device: "joystick" });
  });

  it("hands over once the old one is let go", () => {
    const next = after(["keys", AHEAD], ["keys", CENTRE], ["joystick", LEFT]);
    expect(heeded(next)).toMatchObject({ at: LEFT, device: "joystick", waiting: [] });
  });

  it("is not held up by a gamepad that was never heeded", () => {
    expect(heeded(after(["gamepad:0", AHEAD], ["keys", LEFT]))).toMatchObject({ at: LEFT, device: "keys" });
  });

  it("stands when the device in control is unplugged, and does not trust it when it returns", () => {
    const without = gone(after(["gamepad:0", CENTRE], ["gamepad:0", AHEAD]), "gamepad:0");
    expect(heeded(without).at).toBe(CENTRE);
    expect(heeded(read(without, "gamepad:0", AHEAD, ZONE)).at).toBe(CENTRE);
  });

  it("tells two gamepads apart", () => {
    const two = after(["gamepad:0", CENTRE], ["gamepad:1", CENTRE], ["gamepad:0", AHEAD], ["gamepad:1", LEFT]);
    expect(heeded(two)).toEqual({ at: AHEAD, device: "gamepad", waiting: ["gamepad:1"] });
  });

  it("needs every centre anew once the page was left", () => {
    const left = dropped(after(["gamepad:0", CENTRE], ["gamepad:0", AHEAD]));
    expect(heeded(left)).toEqual({ at: CENTRE, device: "none", waiting: ["gamepad:0"] });
    expect(heeded(read(left, "gamepad:0", LEFT, ZONE)).at).toBe(CENTRE);
  });

  it("needs the centre of one source that looks dead, and leaves the other to steer", () => {
    const two = after(["gamepad:0", CENTRE], ["keys", CENTRE], ["gamepad:0", AHEAD]);
    const dead = dropped(two, "gamepad:0");
    expect(heeded(dead)).toEqual({ at: CENTRE, device: "none", waiting: ["gamepad:0"] });
    expect(heeded(read(dead, "keys", LEFT, ZONE))).toEqual({ at: LEFT, device: "keys", waiting: ["gamepad:0"] });
    expect(heeded(dropped(read(dead, "keys", LEFT, ZONE), "gamepad:0")).at).toBe(LEFT);
  });

  it("is never steered by anything but one source's own deflection", () => {
    // Any order of readings: what goes out is the centre, or what one source says just now.
    let seed = 7;
    const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    const sources: Source[] = ["joystick", "keys", "switch", "gamepad:0"];
    const last = new Map<Source, typeof AHEAD>();
    let arbiter = NOBODY;
    for (let k = 0; k < 3000; k++) {
      const source = sources[Math.floor(4 * random())]!;
      const at = random() < 0.4 ? CENTRE : deflection(2 * random() - 1, 2 * random() - 1);
      const before = steering(arbiter, ZONE);
      arbiter = read(arbiter, source, at, ZONE);
      last.set(source, at);
      const now = steering(arbiter, ZONE);
      if (now.device !== "none") expect([...last.values()]).toContain(now.at);
      // from one device to another only through the centre
      if (before.device !== "none" && now.device !== "none") expect(now.device).toBe(before.device);
    }
  });
});
