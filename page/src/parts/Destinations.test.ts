import { fireEvent, render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, beforeEach, describe, expect, it } from "vitest";
import { chair } from "../chair.svelte";
import type { ChairState, SceneInfo } from "../messages";
import { remember } from "../places";
import Destinations from "./Destinations.svelte";

const PLACES = ["Ward 1", "Ward 2", "Cafeteria"].map((name, k) => ({ name, x: k, y: 0, area: [] }));

async function goal(name: string | null): Promise<void> {
  chair.heard({ type: "state", pose: [0, 0, 0], goal: name ? { name, x: 9, y: 9 } : null } as unknown as ChairState);
  await tick();
}

const names = (): (string | null)[] => screen.getAllByRole("button").map((button) => button.textContent!.trim());
const other = (): HTMLElement | null => screen.queryByRole("button", { name: "Choose another destination" });

beforeEach(() => {
  localStorage.clear();
  chair.scene = { places: PLACES } as unknown as SceneInfo;
});
afterEach(() => {
  chair.scene = null;
  chair.state = null;
});

describe("the list of places", () => {
  it("that was opened on the way stays as it is when the chair arrives", async () => {
    await goal("Ward 1");
    render(Destinations);
    await fireEvent.click(other()!);
    const before = names();
    remember("Cafeteria");
    await goal(null);
    expect(names()).toEqual(before);
  });

  it("does not open under a hand, but when it is gone", async () => {
    await goal("Ward 1");
    render(Destinations);
    const list = screen.getByRole("group", { name: "Destination" });
    await fireEvent.pointerEnter(list);
    await goal(null);
    expect(other()).toBeTruthy();
    await fireEvent.pointerLeave(list);
    expect(other()).toBeNull();
    expect(names()).toContain("Ward 2");
  });
});
