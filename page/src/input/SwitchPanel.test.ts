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
  inputs.scanner.change({ count });
  render(SwitchPanel, { inputs });
  await Promise.resolve();
}

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

  it("offers no direction that would do nothing", async () => {
    state({ link: "confirm" });
    await show(1);
    expect(screen.getByRole<HTMLButtonElement>("button", { name: "Left" }).disabled).toBe(true);
    vi.spyOn(inputs, "drive");
    inputs.drive("left");
    expect(inputs.push).toBeNull();
  });
});
