import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Chair } from "../chair.svelte";
import type { Heartbeat, FromPage, ChairState } from "../messages";
import { Inputs } from "./inputs.svelte";
import type { Pad } from "./pads";

let sent: FromPage[];
let tell: (status: string) => void;
let chair: Chair;
let inputs: Inputs;
let end: () => void;
let pads: Pad[];
let focused: boolean;
let again: number;

const READY = { link: "ready", driver: "me", mode: "shared", pace: "normal" } as const;

function state(now: Partial<ChairState> = {}): void {
  const standing = { seq: 0, time: 0, pose: [0, 0, 0], speed: 0, turn_rate: 0, command: [0, 0], rider_authority: 0 };
  chair.heard({ type: "state", ...standing, ...READY, ...now } as ChairState);
}

beforeEach(() => {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "setInterval", "clearInterval", "performance"] });
  localStorage.clear();
  focused = true;
  vi.spyOn(document, "visibilityState", "get").mockReturnValue("visible");
  vi.spyOn(document, "hasFocus").mockImplementation(() => focused);
  pads = [];
  Object.assign(navigator, { getGamepads: () => pads });
  sent = [];
  again = 0;
  chair = new Chair();
  chair.client = "me";
  chair.rider = { dead_zone: 0.1, dwell: 1, tremor_filter: 0, start_at_once: false, switches: null };
  state();
  inputs = new Inputs(
    {
      send: (message) => sent.push(message) > 0,
      again: () => again++,
      watch: (watcher) => {
        tell = watcher;
        watcher("open");
        return () => undefined;
      },
    },
    chair,
  );
  end = inputs.start();
});
afterEach(() => {
  end();
  vi.restoreAllMocks();
  vi.useRealTimers();
  document.body.innerHTML = "";
});

const key = (name: "keydown" | "keyup", code: string, more: KeyboardEventInit = {}) => {
  const event = new KeyboardEvent(name, { code, bubbles: true, cancelable: true, ...more });
  (document.activeElement ?? document.body).dispatchEvent(event);
  return event;
};
const last = () => sent.filter((message): message is Heartbeat => message.type === "heartbeat").at(-1)!;
const count = (type: string) => sent.filter((message) => message.type === type).length;
const pass = (time: number) => vi.advanceTimersByTime(time);
const pad = (forward: number, down: number[] = [], index = 0): Pad => ({
  index,
  connected: true,
  mapping: "standard",
  timestamp: 0,
  axes: [0, -forward],
  buttons: Array.from({ length: 17 }, (_, n) => ({ pressed: down.includes(n), value: 0 })),
});

describe("a page that is not heard", () => {
  it("connects anew where it drives, is in front and beats all the same", () => {
    state({ link: "no_heartbeat" });
    pass(1_900);
    expect(again).toBe(0);
    pass(300);
    expect(again).toBe(1);
  });

  it.each([
    ["another one drives", () => state({ link: "no_heartbeat", driver: "other" })],
    ["it is heard again", () => state()],
    ["it is not in front", () => { focused = false; window.dispatchEvent(new Event("blur")); }],
  ])("does not where %s", (_, change) => {
    state({ link: "no_heartbeat" });
    pass(1_500);
    change();
    pass(5_000);
    expect(again).toBe(0);
  });
});

describe("keys", () => {
  it("drive, and stop at once when they are let go", () => {
    key("keydown", "ArrowUp");
    pass(1000);
    expect(last()).toMatchObject({ forward: 1, left: 0, device: "keys" });
    key("keyup", "ArrowUp");
    expect(last()).toMatchObject({ forward: 0, left: 0, device: "none" });
  });

  it("belong to the browser while another page drives, and to a field while something is typed", () => {
    document.body.innerHTML = "<input>";
    document.querySelector("input")!.focus();
    expect(key("keydown", "KeyW").defaultPrevented).toBe(false);
    pass(500);
    expect(last().forward).toBe(0);
    document.querySelector("input")!.blur();
    chair.client = "other";
    expect(key("keydown", "ArrowUp").defaultPrevented).toBe(false);
  });

  it("count from the first press on, even where the page learns only later that it drives", () => {
    state({ driver: null });
    key("keydown", "ArrowUp");
    state();
    key("keydown", "ArrowUp", { repeat: true });
    pass(1000);
    expect(last()).toMatchObject({ forward: 1, device: "keys" });
  });

  it("let go when the window does, and a key held since then does not count", () => {
    key("keydown", "ArrowUp");
    pass(600);
    window.dispatchEvent(new Event("blur"));
    expect(last()).toMatchObject({ forward: 0, visible: false });
    const beats = sent.length;
    pass(2000);
    expect(sent).toHaveLength(beats);
    window.dispatchEvent(new Event("focus"));
    key("keydown", "ArrowUp", { repeat: true });
    pass(500);
    expect(last()).toMatchObject({ forward: 0, visible: true });
  });

  it("stop: Escape anywhere, Space where no control has the focus, both once", () => {
    document.body.innerHTML = "<button>x</button><input>";
    document.querySelector("input")!.focus();
    key("keydown", "Escape");
    key("keydown", "Escape", { repeat: true });
    expect(count("stop")).toBe(1);
    expect(key("keydown", "Space").defaultPrevented).toBe(false);
    document.querySelector("button")!.focus();
    key("keydown", "Space");
    expect(count("stop")).toBe(1);
    document.querySelector("button")!.blur();
    expect(key("keydown", "Space").defaultPrevented).toBe(true);
    expect(count("stop")).toBe(2);
  });

  it("stop by Space whatever button has the focus, while the chair moves", () => {
    document.body.innerHTML = "<button>Go on</button><input>";
    document.querySelector("button")!.focus();
    state({ speed: 0.4 });
    expect(key("keydown", "Space").defaultPrevented).toBe(true);
    expect(key("keyup", "Space").defaultPrevented).toBe(true);
    expect(count("stop")).toBe(1);
    document.querySelector("input")!.focus();
    expect(key("keydown", "Space").defaultPrevented).toBe(false);
    expect(key("keyup", "Space").defaultPrevented).toBe(false);
  });

  it("stop a moving chair by Space while Ctrl or Alt is latched", () => {
    key("keydown", "Space", { altKey: true });
    expect(count("stop")).toBe(0); // of a standing chair it is the browser's
    state({ speed: 0.4 });
    key("keydown", "Space", { altKey: true });
    key("keydown", "Space", { ctrlKey: true });
    expect(count("stop")).toBe(2);
  });

  it("tell the chair truly that they are still held after STOP", () => {
    key("keydown", "ArrowUp");
    pass(600);
    key("keydown", "Space");
    pass(200);
    expect(last().forward).toBe(1);
  });
});

describe("stick and gamepad", () => {
  it("one at a time: a gamepad at rest leaves keys alone, one that is pulled waits", () => {
    pads = [pad(0.02)];
    key("keydown", "ArrowUp");
    pass(700);
    expect(last()).toMatchObject({ forward: 1, device: "keys" });
    pads = [pad(-1)];
    pass(100);
    expect(last()).toMatchObject({ forward: 1, device: "keys" });
    expect(inputs.steering.waiting).toEqual(["gamepad:0"]);
    key("keyup", "ArrowUp");
    pass(200);
    expect(last()).toMatchObject({ forward: 0, device: "none" });
    pads = [pad(0)];
    pass(40);
    pads = [pad(-1)];
    pass(100);
    expect(last()).toMatchObject({ forward: -1, device: "gamepad" });
  });

  it("a gamepad that comes deflected has to show its centre", () => {
    pads = [pad(1)];
    pass(500);
    expect(last().forward).toBe(0);
    expect(inputs.pads).toBe(1);
  });

  it("a gamepad that is unplugged stops", () => {
    pads = [pad(0)];
    pass(40);
    pads = [pad(1)];
    pass(100);
    expect(last().forward).toBe(1);
    pads = [];
    pass(40);
    expect(last()).toMatchObject({ forward: 0, device: "none" });
  });

  it("a gamepad's buttons stop and go on, once a press", () => {
    pads = [pad(0)];
    pass(40);
    pads = [pad(0, [1])];
    pass(400);
    expect(count("stop")).toBe(1);
    state({ link: "confirm" });
    pads = [pad(0, [9])];
    pass(400);
    expect(count("resume")).toBe(1);
  });

  it("stops by each of a gamepad's buttons, whatever else is latched on it or on another one", () => {
    pads = [pad(0), pad(0, [2], 1)];
    pass(40);
    expect(count("stop")).toBe(1); // held as it came
    const held: number[] = [];
    for (const [n, button] of [5, 0, 3, 1].entries()) {
      held.push(button);
      pads = [pad(0, held), pad(0, [2], 1)];
      pass(1000);
      expect(count("stop")).toBe(1 + n); // 5 is no STOP
    }
    pads = [pad(0, held), pad(0, [2, 3], 1)];
    pass(1000);
    expect(count("stop")).toBe(5);
  });

  it("goes on by a press of Start that it saw: not by one from before it came back", () => {
    pads = [pad(0)];
    pass(40);
    window.dispatchEvent(new Event("blur"));
    pass(100);
    state({ link: "confirm" });
    pads = [pad(0, [9])];
    window.dispatchEvent(new Event("focus"));
    pass(100);
    expect(count("resume")).toBe(0);
    pads = [pad(0, [])];
    pass(100);
    pads = [pad(0, [9])];
    pass(100);
    expect(count("resume")).toBe(1);
  });

  it("drops a gamepad that repeats itself, says so, and heeds it after its centre only", () => {
    pads = [pad(0)];
    pass(40);
    pads = [pad(0.8)];
    pass(4_900);
    expect(last()).toMatchObject({ forward: 0.8, device: "gamepad" });
    expect(inputs.frozen).toBe(false);
    pass(300);
    expect(last()).toMatchObject({ forward: 0, device: "none" });
    expect(inputs.frozen).toBe(true);
    pads = [pad(0.7)]; // it was only held still
    pass(100);
    expect(last().forward).toBe(0);
    expect(inputs.frozen).toBe(false);
    expect(inputs.steering.waiting).toEqual(["gamepad:0"]);
    key("keydown", "ArrowUp");
    pass(600);
    expect(last()).toMatchObject({ forward: 1, device: "keys" });
    key("keyup", "ArrowUp");
    pads = [pad(0)];
    pass(10_000);
    pads = [pad(0.7)];
    pass(100);
    expect(last()).toMatchObject({ forward: 0.7, device: "gamepad" });
  });

  it("confirms what was shown just now, after a beat, and nothing else", () => {
    inputs.resume();
    expect(count("resume")).toBe(0); // ready: the chair waits for nothing
    pads = [pad(0)];
    pass(40);
    state({ link: "confirm" });
    pads = [pad(1)]; // since the last look: the chair sees that the stick is held
    inputs.resume();
    expect(sent.slice(-2)).toMatchObject([{ type: "heartbeat", forward: 1 }, { type: "resume" }]);
    pass(1_100); // without a state, as of a page that was busy
    inputs.resume();
    expect(count("resume")).toBe(1);
  });

  it("a stick drives and springs back", () => {
    inputs.pull({ forward: 0.5, left: 0.5 });
    pass(50);
    expect(last()).toMatchObject({ forward: 0.5, left: 0.5, device: "joystick" });
    inputs.pull({ forward: 0, left: 0 });
    expect(last()).toMatchObject({ forward: 0, device: "none" });
  });
});

describe("link", () => {
  it("lost and found again: numbers begin anew, what a switch drove does not go on", () => {
    inputs.drive("forward");
    pass(500);
    expect(last()).toMatchObject({ forward: 0.6, device: "switch" });
    tell("lost");
    const beats = sent.length;
    pass(1000);
    expect(sent).toHaveLength(beats);
    tell("open");
    expect(sent[beats]).toMatchObject({ type: "heartbeat", seq: 0 });
    expect(last().forward).toBe(0);
  });
});

describe("one switch", () => {
  const lit = () => document.querySelector("[data-scanned]")?.textContent;
  const press = () => (key("keydown", "Space"), key("keyup", "Space"));

  beforeEach(() => {
    document.body.innerHTML = `<button data-scan="drive">Forward</button>
      <div data-scan-group="Places"><button data-scan>A</button><button data-scan>B</button></div>
      <button data-scan="last">Help</button>`;
    document.querySelector("button")!.onclick = () => inputs.drive("forward");
    inputs.scanner.change({ count: 1 });
    pass(40);
  });

  it("begins with a press and dwells as the therapist says", () => {
    expect(lit()).toBeUndefined();
    press();
    expect(lit()).toBe("Forward");
    pass(1040);
    expect(inputs.scanner.lit?.label).toBe("Places");
    chair.rider = { dead_zone: 0.1, dwell: 3, tremor_filter: 0, start_at_once: false, switches: null };
    pass(1500);
    expect(inputs.scanner.lit?.label).toBe("Places");
  });

  it("are as many as the therapist has set, until the rider changes it", () => {
    const rider = { dead_zone: 0.1, dwell: 1, tremor_filter: 0, start_at_once: false };
    const settings = (switches: 0 | 1 | 2 | null): void => {
      chair.rider = { ...rider, switches };
      pass(40);
    };
    settings(2);
    expect(inputs.scanner.settings.count).toBe(2);
    inputs.scanner.change({ count: 1 });
    pass(40);
    expect(inputs.scanner.settings.count).toBe(1);
    settings(null);
    expect(inputs.scanner.settings.count).toBe(1);
    settings(0);
    expect(inputs.scanner.settings.count).toBe(0);
  });

  it("drives what is chosen until it is pressed again", () => {
    press();
    pass(100);
    press();
    pass(100);
    state({ speed: 0.3 });
    pass(2000);
    expect(last()).toMatchObject({ forward: 0.6, device: "switch" });
    expect(lit()).toBeUndefined();
    press();
    expect(last().forward).toBe(0);
    expect(count("stop")).toBe(0);
    pass(100);
    press(); // the same shaking hand
    expect(count("stop")).toBe(0);
  });

  it("drives only while held where that is wanted", () => {
    inputs.scanner.change({ hold: true });
    press();
    pass(100);
    key("keydown", "Space");
    pass(500);
    expect(last().forward).toBe(0.6);
    key("keyup", "Space");
    expect(last().forward).toBe(0);
  });

  it("ends by itself when the chair is stopped or taken over", () => {
    inputs.drive("forward");
    pass(100);
    state({ link: "stick_held" });
    pass(40);
    expect(last().forward).toBe(0);
    inputs.drive("forward");
    pass(100);
    expect(last().forward).toBe(0);
  });

  it("is STOP at every press while the chair follows its way, even with a field in focus", () => {
    state({ speed: 0.5, goal: { name: "A", x: 0, y: 0 } });
    document.body.insertAdjacentHTML("beforeend", "<input>");
    document.querySelector("input")!.focus();
    press();
    expect(count("stop")).toBe(1);
  });

  it("opens groups, and clicks what is chosen in them", () => {
    const chosen = vi.fn();
    document.querySelectorAll("button")[2]!.onclick = chosen;
    press();
    pass(1040);
    press(); // Places opens: a pause and its own dwell on A
    expect(inputs.scanner.lit?.label).toBe("A");
    pass(2040);
    expect(lit()).toBe("B");
    press();
    expect(chosen).toHaveBeenCalledOnce();
  });

  it("goes to Start where a place is chosen, and waits there for its routes", () => {
    document.querySelectorAll("button")[1]!.onclick = () =>
      document.body.insertAdjacentHTML("beforeend", `<button data-scan="first" aria-disabled="true" aria-busy="true">Start</button>`);
    press();
    pass(1040);
    press();
    pass(150);
    press(); // A
    pass(5000);
    expect(lit()).toBe("Start");
    const start = document.querySelector("[data-scan=first]")!;
    start.setAttribute("aria-disabled", "false");
    start.setAttribute("aria-busy", "false");
    pass(900);
    expect(lit()).toBe("Start");
    pass(300);
    expect(lit()).toBe("Forward");
  });

  it("does not wait for ever for what is not there", () => {
    document.querySelectorAll("button")[1]!.onclick = () =>
      document.body.insertAdjacentHTML("beforeend", `<button data-scan="first" aria-disabled="true" aria-busy="true">Start</button>`);
    press();
    pass(1040);
    press();
    pass(150);
    press();
    pass(13_000);
    expect(lit()).not.toBe("Start");
  });

  it("goes to the first row of what a tab opens", () => {
    document.body.innerHTML = `<button data-scan="drive">Forward</button><button data-scan aria-controls="panel">Speed</button>
      <section id="panel"></section>`;
    document.querySelectorAll("button")[1]!.onclick = () =>
      (document.querySelector("#panel")!.innerHTML = `<div data-scan-group="Row"><button data-scan>Slow</button><button data-scan>Brisk</button></div>`);
    press();
    pass(1040);
    press(); // Speed
    pass(60);
    expect(inputs.scanner.lit?.label).toBe("Row");
  });

  it.each(["one", "two"])("works right after %s was chosen, with the focus still on the radio button", (which) => {
    document.body.insertAdjacentHTML("beforeend", `<div data-own-keys><input type="radio" checked><input type="text"></div>`);
    inputs.scanner.change({ count: which === "one" ? 1 : 2 });
    document.querySelector("input")!.focus();
    press();
    expect(lit()).toBe("Forward");
    if (which === "two") key("keydown", "Enter");
    if (which === "two") expect(inputs.scanner.lit?.label).toBe("Places");
    document.querySelectorAll("input")[1]!.focus();
    expect(key("keydown", "Space").defaultPrevented).toBe(false);
  });

  it("takes the key that is pressed to learn, but never Escape", () => {
    inputs.scanner.learning = "choose";
    key("keydown", "KeyM");
    expect(inputs.scanner.settings).toMatchObject({ choose: "KeyM", step: "Enter" });
    inputs.scanner.learning = "choose";
    key("keydown", "Enter");
    expect(inputs.scanner.settings).toMatchObject({ choose: "Enter", step: "KeyM" });
    inputs.scanner.learning = "choose";
    key("keydown", "Escape");
    expect(inputs.scanner.settings.choose).toBe("Enter");
    expect(count("stop")).toBe(1);
  });
});

describe("two switches", () => {
  it("one steps, one chooses, and either stops", () => {
    document.body.innerHTML = `<button data-scan>A</button><button data-scan>B</button>`;
    const chosen = vi.fn();
    document.querySelectorAll("button")[1]!.onclick = chosen;
    inputs.scanner.change({ count: 2 });
    pass(40);
    key("keydown", "Enter");
    pass(100);
    key("keydown", "Enter");
    expect(inputs.scanner.lit?.label).toBe("B");
    pass(20_000);
    expect(inputs.scanner.lit?.label).toBe("B");
    key("keydown", "Space");
    expect(chosen).toHaveBeenCalledOnce();
    state({ speed: 0.4 });
    key("keydown", "Enter");
    expect(count("stop")).toBe(1);
  });
});

describe("a switch that bounces", () => {
  beforeEach(() => {
    document.body.innerHTML = `<button data-scan="drive">Forward</button><button data-scan>Go on</button><input data-scan>`;
    document.querySelector("button")!.onclick = () => inputs.drive("forward");
    document.querySelectorAll("button")[1]!.onclick = () => inputs.resume();
    document.querySelector("input")!.onclick = (event) => (event.target as HTMLElement).focus();
    inputs.scanner.change({ count: 1 });
    pass(40);
  });

  /** The contact opens and closes again after these times, ms, and stays as it is. */
  function bounces(name: "keydown" | "keyup", code: string, times: readonly number[]): void {
    key(name, code);
    let before = 0;
    for (const [n, time] of times.entries()) {
      pass(time - before);
      before = time;
      key(n % 2 === 0 ? (name === "keydown" ? "keyup" : "keydown") : name, code);
    }
    pass(200 - before);
  }
  const TRAINS = [[30, 31], [30, 80], [5, 12, 40, 45, 75, 80]];
  const press = (code = "Space", train: readonly number[] = []) => {
    bounces("keydown", code, train);
    bounces("keyup", code, train);
  };

  it.each(TRAINS.map((train) => [train]))("drives on after the press that chose: %s", (train) => {
    press("Space", train);
    expect(inputs.push).toBeNull();
    expect(inputs.scanner.lit?.label).toBe("Forward");
    press("Space", train);
    pass(1000);
    expect(last()).toMatchObject({ forward: 0.6, device: "switch" });
    key("keydown", "Space");
    expect(last().forward).toBe(0); // at its first edge
    pass(30);
    key("keyup", "Space");
    expect(inputs.push).toBeNull();
  });

  it.each(TRAINS.map((train) => [train]))("drives while it is held, and no longer: %s", (train) => {
    inputs.scanner.change({ hold: true });
    press("Space", train);
    const letGo = vi.spyOn(inputs, "letGo");
    bounces("keydown", "Space", train);
    pass(1000);
    expect(letGo).not.toHaveBeenCalled();
    expect(last().forward).toBe(0.6);
    key("keyup", "Space");
    expect(last().forward).toBe(0);
    key("keydown", "Space");
    bounces("keyup", "Space", train);
    pass(500);
    expect(inputs.push).toBeNull(); // and nothing was chosen
    expect(inputs.scanner.lit?.label).toBe("Forward");
  });

  it.each(TRAINS.map((train) => [train]))("stops at its first edge, and its bounces do not go on: %s", (train) => {
    state({ speed: 0.5, goal: { name: "A", x: 0, y: 0 } });
    document.querySelectorAll("button")[0]!.remove(); // “Go on” is the first item
    pass(300);
    key("keydown", "Space");
    expect(count("stop")).toBe(1);
    state({ link: "confirm" });
    press("Space", train);
    expect(count("resume")).toBe(0);
    expect(count("stop")).toBe(1);
  });

  it("steps once with each press of two, and each stops for itself", () => {
    inputs.scanner.change({ count: 2 });
    press("Enter", [30, 80]);
    press("Enter", [30, 80]);
    expect(inputs.scanner.lit?.label).toBe("Go on");
    key("keydown", "Enter");
    state({ speed: 0.4 });
    key("keydown", "Space");
    expect(count("stop")).toBe(1); // whatever the other one just did, and though it is held
    key("keyup", "Space");
    pass(200);
    key("keydown", "Space");
    expect(count("stop")).toBe(2);
  });

  it("counts after a release that nobody saw, or that a field saw", () => {
    inputs.scanner.change({ count: 2 });
    press("Enter");
    press("Enter");
    press("Enter"); // the field
    press("Space");
    expect(document.activeElement?.tagName).toBe("INPUT");
    state({ speed: 0.4 });
    key("keydown", "Space"); // and never comes up
    pass(200);
    key("keydown", "Space");
    expect(count("stop")).toBe(2);
  });

  it("counts, within the bounce time after its release, once the contact stays closed", () => {
    press();
    state({ speed: 0.4 });
    key("keydown", "Space");
    pass(150);
    key("keyup", "Space");
    pass(50);
    key("keydown", "Space");
    expect(count("stop")).toBe(1);
    pass(60);
    expect(count("stop")).toBe(2);
  });

  it.each([
    [0, 33], [1, 33], [25, 33], [0, 130], [60, 130],
  ])("chooses once however long it is held, where each repeat opens it for %d ms every %d ms", (open, every) => {
    const drive = vi.spyOn(inputs, "drive");
    key("keydown", "Space");
    pass(500);
    for (let time = 0; time < 3000; time += every) {
      key("keyup", "Space");
      pass(open);
      key("keydown", "Space");
      pass(every - open);
    }
    pass(200);
    expect(drive).not.toHaveBeenCalled();
    state({ speed: 0.4 });
    key("keyup", "Space");
    pass(100);
    key("keydown", "Space");
    expect(count("stop")).toBe(1);
  });

  it("bounces for as long as is set", () => {
    inputs.scanner.change({ bounce: 250 });
    press("Space", [30, 180]);
    pass(250);
    press("Space", [30, 180]);
    pass(500);
    expect(inputs.push).not.toBeNull();
    inputs.scanner.change({ bounce: 0 });
    key("keydown", "Space");
    key("keyup", "Space");
    expect(inputs.push).toBeNull();
  });
});
