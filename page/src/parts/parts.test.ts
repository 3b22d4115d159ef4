import { render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, describe, expect, it } from "vitest";
import { chair } from "../chair.svelte";
import type { RideEnded, ChairState } from "../messages";
import ReloadPrompt from "./ReloadPrompt.svelte";
import Rating from "./Rating.svelte";

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
