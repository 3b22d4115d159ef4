import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { CENTRE, deflection } from "./deflection";
import { Heartbeat, type BeatOut } from "./heartbeat";

let beats: BeatOut[];
let heart: Heartbeat;

beforeEach(() => {
  vi.useFakeTimers({ now: 0 });
  beats = [];
  heart = new Heartbeat((beat) => beats.push(beat), () => Date.now());
});
afterEach(() => vi.useRealTimers());

const AHEAD = deflection(0.8, 0);

describe("heartbeat", () => {
  it("says nothing before there is a connection", () => {
    heart.put(AHEAD, "keys");
    vi.advanceTimersByTime(1000);
    expect(beats).toEqual([]);
  });

  it("beats at once and then ten times a second, each with a number of its own", () => {
    heart.connected();
    vi.advanceTimersByTime(1000);
    expect(beats.map((beat) => beat.sent)).toEqual([0, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000]);
    expect(beats.map((beat) => beat.seq)).toEqual([...beats.keys()]);
  });

  it("tells at once that the page is alive, before what counts only then", () => {
    heart.assure();
    expect(beats).toEqual([]); // not connected
    heart.connected();
    vi.advanceTimersByTime(70);
    heart.assure();
    expect(beats.map((beat) => beat.sent)).toEqual([0, 70]);
    vi.advanceTimersByTime(100);
    expect(beats.at(-1)).toMatchObject({ seq: 2, sent: 170 });
    heart.present(false);
    heart.assure();
    expect(beats.at(-1)).toMatchObject({ seq: 3, visible: false });
  });

  it("tells a change at once", () => {
    heart.connected();
    vi.advanceTimersByTime(50);
    heart.put(AHEAD, "keys");
    expect(beats.at(-1)).toMatchObject({ sent: 50, forward: 0.8, device: "keys", visible: true });
  });

  it("does not let a press wait for the steady beat before it", () => {
    heart.connected();
    vi.advanceTimersByTime(101); // a steady beat at 100
    heart.put(AHEAD, "keys");
    expect(beats.at(-1)).toMatchObject({ sent: 101, forward: 0.8 });
    vi.advanceTimersByTime(10);
    heart.put(deflection(0.8, 0.5), "keys");
    expect(beats.at(-1)).toMatchObject({ sent: 101 }); // another change waits
    vi.advanceTimersByTime(24);
    expect(beats.at(-1)).toMatchObject({ forward: 0.8, left: 0.5 });
  });

  it("never sends more than thirty a second, and the newest at last", () => {
    heart.connected();
    for (let k = 1; k <= 1000; k++) {
      vi.advanceTimersByTime(1);
      heart.put(deflection((k % 97) / 100, 0.1), "joystick");
    }
    // Thirty a second, the one of the connection, and the first change, which waits for neither.
    expect(beats.length).toBeLessThanOrEqual(32);
    expect(beats.length).toBeGreaterThan(25);
    vi.advanceTimersByTime(34);
    // 1000 mod 97 = 30
    expect(beats.at(-1)?.forward).toBe(0.3);
  });

  it("does not let a stick that is let go wait", () => {
    heart.connected();
    vi.advanceTimersByTime(40);
    heart.put(AHEAD, "joystick");
    vi.advanceTimersByTime(1);
    heart.put(CENTRE, "none");
    expect(beats.at(-1)).toMatchObject({ sent: 41, forward: 0, left: 0, device: "none" });
  });

  it("says with its last beat that nobody looks, and then is silent", () => {
    heart.connected();
    heart.put(AHEAD, "keys");
    vi.advanceTimersByTime(110);
    heart.present(false);
    expect(beats.at(-1)).toMatchObject({ sent: 110, forward: 0, device: "none", visible: false });
    const count = beats.length;
    heart.put(AHEAD, "keys");
    vi.advanceTimersByTime(5000);
    expect(beats).toHaveLength(count);
  });

  it("begins again at the centre when somebody looks", () => {
    heart.connected();
    heart.put(AHEAD, "keys");
    heart.present(false);
    heart.present(true);
    expect(beats.at(-1)).toMatchObject({ forward: 0, device: "none", visible: true });
  });

  it("numbers anew on a new connection, and says there too when nobody looks", () => {
    heart.connected();
    vi.advanceTimersByTime(500);
    heart.disconnected();
    const count = beats.length;
    vi.advanceTimersByTime(500);
    expect(beats).toHaveLength(count);
    heart.present(false);
    heart.connected();
    expect(beats.slice(count)).toMatchObject([{ seq: 0, visible: false }]);
  });
});
