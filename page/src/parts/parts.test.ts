import { render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { chair } from "../chair.svelte";
import { explained } from "../explained.svelte";
import { mapView } from "../map/mapView.svelte";
import type { RideEnded, ChairState } from "../messages";
import FirstUse from "./FirstUse.svelte";
import ReloadPrompt from "./ReloadPrompt.svelte";
import Rating from "./Rating.svelte";
import { surroundings } from "../surroundings.svelte";

const ENDED: RideEnded = { type: "ride_ended", ride: "r1", outcome: "arrived", duration: 60, length: 30 };
const driven = (ride: string): void => chair.heard({ type: "state", ride } as ChairState);

afterEach(() => {
  chair.ended = null;
  chair.state = null;
  chair.status = "connecting";
  sessionStorage.clear();
});

describe("the rating", () => {
  it("is asked for until the next ride begins", async () => {
    render(Rating);
    driven("r1");
    chair.heard(ENDED);
    driven("");
    await tick();
    expect(screen.getByRole("group", { name: "Rate this ride" })).toBeTruthy();
    driven("r2");
    await tick();
    expect(screen.queryByRole("group")).toBeNull();
  });
});

describe("the rating and a sheet", () => {
  it("are not over the map together: the card comes back when the sheet is gone", async () => {
    render(Rating);
    chair.heard(ENDED);
    mapView.covered = 300;
    await tick();
    expect(screen.queryByRole("group")).toBeNull();
    mapView.covered = 0;
    await tick();
    expect(screen.getByRole("group", { name: "Rate this ride" })).toBeTruthy();
  });
});

describe("the note on a mode", () => {
  const GOAL = { name: "Ward 4", x: 0, y: 0 };
  const under = (goal: ChairState["goal"]): void =>
    chair.heard({ type: "state", driver: "me", goal, mode: "shared", ride: "" } as ChairState);
  const note = (): HTMLElement | null => screen.queryByRole("group", { name: "What this mode does" });

  beforeEach(() => {
    vi.useFakeTimers();
    chair.client = "me";
    explained.topics = [];
    render(FirstUse);
  });
  afterEach(() => {
    vi.useRealTimers();
    chair.client = "";
  });

  it("covers the map for 12 s at most, whatever the chair tells meanwhile", async () => {
    under(GOAL);
    await tick();
    for (let k = 0; k < 11; k++) {
      vi.advanceTimersByTime(1_000);
      under(GOAL);
      await tick();
      expect(note()).not.toBeNull();
    }
    vi.advanceTimersByTime(1_000);
    await tick();
    expect(note()).toBeNull();
  });

  it("counts as read when the trip ends", async () => {
    under(GOAL);
    await tick();
    expect(note()).not.toBeNull();
    under(null);
    await tick();
    under(GOAL);
    await tick();
    expect(note()).toBeNull();
    expect(explained.topics).toEqual(["shared"]);
  });
});

describe("the note on the arcs", () => {
  const arc = (): HTMLElement | null => screen.queryByRole("group", { name: "What the arcs mean" });
  const narrow = [{ angle: 0, freedom: "narrow", by: "wall" }] as const;

  afterEach(() => {
    chair.client = "";
    surroundings.ring = [];
  });

  it("is shown once, with the first of them, after the note on the mode, and stays when they go", async () => {
    explained.topics = [];
    chair.client = "me";
    render(FirstUse);
    chair.heard({ type: "state", driver: "me", goal: { name: "Ward 4", x: 0, y: 0 }, mode: "shared", ride: "" } as ChairState);
    surroundings.ring = narrow;
    await tick();
    expect(arc()).toBeNull(); // one note at a time
    screen.getByRole("button", { name: "OK" }).click();
    await tick();
    expect(arc()?.textContent).toContain("a thin orange one is narrow, a thick red one is blocked");
    surroundings.ring = [];
    await tick();
    expect(arc()).not.toBeNull();
    screen.getByRole("button", { name: "OK" }).click();
    surroundings.ring = narrow;
    await tick();
    expect(arc()).toBeNull();
  });
});

describe("a page of another version", () => {
  it("says so, once loading it anew by itself did not help", async () => {
    sessionStorage.setItem("cohelm.reloaded", "1");
    render(ReloadPrompt);
    expect(screen.queryByRole("alert")).toBeNull();
    chair.status = "outdated";
    await tick();
    expect(screen.getByRole("alert").textContent).toContain("This page is out of date. Reload it.");
    expect(screen.getByRole("button", { name: "Reload" })).toBeTruthy();
    chair.status = "open";
    await tick();
    expect(sessionStorage.getItem("cohelm.reloaded")).toBeNull();
  });
});
