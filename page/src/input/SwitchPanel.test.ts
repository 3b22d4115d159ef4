import { fireEvent, render, screen } from "@testing-library/svelte";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Chair } from "../chair.svelte";
import type { FromPage, ChairState } from "../messages";
import { Inputs } from "./inputs.svelte";
import SwitchPanel from "./SwitchPanel.svelte";

let sent: FromPage[];
let chair: Chair;
let inputs: Inputs;

beforeEach(() => {
  localStorage.clear();
  sent = [];
  chair = new Chair();
  chair.client = "me";
  inputs = new Inputs({ send: (message) => sent.push(message) > 0, watch: () => () => undefined, again: () => undefined }, chair);
});

const state = (now: Partial<ChairState>) =>
  chair.heard({ type: "state", link: "ready", driver: "me", mode: "assisted", speed: 0, turn_rate: 0, ...now } as ChairState);
const words = () => screen.getByTestId("scan").textContent;

async function show(count: 1 | 2): Promise<void> {
  inputs.scanner.change({ count, bounce: 0 }); // no time passes between clicks
  render(SwitchPanel, { inputs });
  await Promise.resolve();
}

/** As jsdom has no pointers of its own. */
const pointer = (element: HTMLElement, name: string, button: number, buttons: number) =>
  fireEvent(element, Object.assign(new MouseEvent(name, { bubbles: true, button, buttons }), { pointerId: 1 }));

describe("panel of the switches", () => {
  it("has one large button for one switch, two for two", async () => {
    state({});
    await show(2);
    expect(screen.getAllByRole("button", { name: /Next|Select/ })).toHaveLength(2);
  });

  it("lights up the directions, and says each aloud", async () => {
    state({});
    await show(1);
    expect(words()).toBe("Press to start");
    expect(screen.getByTestId("scan").getAttribute("aria-live")).toBe("polite");
    await fireEvent.click(screen.getByRole("button", { name: /Select/ }));
    expect(words()).toBe("Forward");
    expect(screen.getByRole("button", { name: "Forward" }).hasAttribute("data-scanned")).toBe(true);
  });

  it("drives what is chosen", async () => {
    state({});
    await show(1);
    const choose = screen.getByRole("button", { name: /Select/ });
    await fireEvent.click(choose);
    await fireEvent.click(choose);
    expect(inputs.push?.direction).toBe("forward");
    expect(inputs.steering).toMatchObject({ device: "switch", at: { forward: 0.6, left: 0 } });
    expect(words()).toBe("Driving forward: press to stop");
  });

  it("turns into STOP while the chair moves", async () => {
    state({ speed: 0.5 });
    await show(1);
    await fireEvent.click(screen.getByRole("button", { name: /Stop/ }));
    expect(sent).toContainEqual({ type: "stop" });
    expect(words()).toBe("Press to STOP");
  });

  it("is STOP with another mouse button latched, for which the browser tells of a movement", async () => {
    state({ speed: 0.5 });
    await show(2);
    const stop = () => sent.filter((message) => message.type === "stop").length;
    for (const [n, choose] of screen.getAllByRole("button", { name: /Stop/ }).entries()) {
      await pointer(choose, "pointerdown", 2, 2);
      expect(stop()).toBe(n);
      await pointer(choose, "pointermove", -1, 2);
      await pointer(choose, "pointermove", 0, 3);
      expect(stop()).toBe(n + 1);
      await pointer(choose, "pointermove", 0, 2);
      await pointer(choose, "pointerup", 2, 0);
      expect(stop()).toBe(n + 1);
    }
  });

  it("offers no direction that would do nothing", async () => {
    state({ link: "confirm" });
    await show(1);
    expect(screen.getByRole<HTMLButtonElement>("button", { name: "Left" }).disabled).toBe(true);
    vi.spyOn(inputs, "drive");
    inputs.drive("left");
    expect(inputs.push).toBeNull();
  });
});
