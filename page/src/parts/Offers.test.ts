import { fireEvent, render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { chair } from "../chair.svelte";
import { selection } from "../mapSelection.svelte";
import type { ChairState } from "../messages";
import { trip } from "../trip.svelte";
import Offers from "./Offers.svelte";

type Offer = ChairState["offers"][number];

const WARD: Offer = { name: "Ward 4", slot: 0, highlighted: false, why: "You steer towards it" };
const LAB: Offer = { name: "Laboratory", slot: 2, highlighted: false, why: "You have come 6 m closer" };

async function offered(offers: Offer[], more: Partial<ChairState> = {}): Promise<void> {
  chair.heard({ type: "state", driver: "me", goal: null, offers, ...more } as ChairState);
  await tick();
}

const names = (): (string | null)[] => screen.queryAllByRole("button").map((button) => button.textContent);

beforeEach(() => {
  chair.client = "me";
  render(Offers);
});

afterEach(() => {
  chair.state = null;
  chair.client = "";
  selection.cancel();
  vi.restoreAllMocks();
});

describe("the offers", () => {
  it("name the place and say why", async () => {
    await offered([WARD, LAB]);
    expect(names()).toEqual(["To Ward 4? You steer towards it", "To Laboratory? You have come 6 m closer"]);
    expect(screen.getByRole("group", { name: "Suggested destinations" })).toBeTruthy();
  });

  it("open the overview of a destination by one press, as the list does, and never by themselves", async () => {
    const go = vi.spyOn(trip, "choose").mockResolvedValue();
    await offered([{ ...WARD, highlighted: true }]);
    expect(go).not.toHaveBeenCalled();
    await fireEvent.click(screen.getByRole("button"));
    expect(go).toHaveBeenCalledExactlyOnceWith({ place: "Ward 4" }, "Ward 4");
  });

  it("keep their slots when one of them goes", async () => {
    await offered([WARD, LAB]);
    const group = screen.getByRole("group");
    const [, lab] = screen.getAllByRole("button");
    expect(group.children).toHaveLength(3);
    await offered([LAB]);
    expect(group.children).toHaveLength(3);
    expect(group.children[2]).toBe(lab);
  });

  it("are other buttons for other places, and the same one while only the reason changes", async () => {
    await offered([WARD]);
    const before = screen.getByRole("button");
    await offered([{ ...WARD, why: "You have come 2 m closer" }]);
    expect(screen.getByRole("button")).toBe(before);
    await offered([{ ...LAB, slot: 0 }]);
    expect(screen.getByRole("button")).not.toBe(before);
  });

  it("are reached by the keyboard and by one switch", async () => {
    await offered([WARD]);
    const button = screen.getByRole("button");
    button.focus();
    expect(document.activeElement).toBe(button);
    expect(button.hasAttribute("data-scan")).toBe(true);
  });

  it("are announced only when one is all but certain", async () => {
    await offered([WARD]);
    expect(screen.getByRole("status").textContent).toBe("");
    await offered([{ ...WARD, highlighted: true }]);
    expect(screen.getByRole("status").textContent).toBe("To Ward 4?");
  });

  it("are gone with a destination, on a page that does not drive, and while the map is in use", async () => {
    await offered([WARD], { goal: { name: "Ward 4", x: 0, y: 0 } });
    expect(names()).toEqual([]);
    await offered([WARD], { driver: "another" });
    expect(names()).toEqual([]);
    await offered([WARD]);
    selection.touch([1, 1], null);
    await tick();
    expect(names()).toEqual([]);
  });
});
