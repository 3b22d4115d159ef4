import { fireEvent, render, screen } from "@testing-library/svelte";
import { tick } from "svelte";
import { afterEach, expect, it } from "vitest";
import MapControls from "./MapControls.svelte";
import { mapView } from "./mapView.svelte";

const names = (): (string | null)[] => screen.getAllByRole("button").map((each) => each.getAttribute("title"));

afterEach(() => {
  mapView.low = mapView.more = false;
});

it("has all tools on a high map", () => {
  render(MapControls, { map: undefined });
  expect(names()).toHaveLength(7);
  expect(names()).not.toContain("More map tools");
});

it("has three tools on a low map, and the others on demand", async () => {
  mapView.low = true;
  render(MapControls, { map: undefined });
  expect(names()).toEqual(["Turn map with the chair", "Overview of the whole route", "More map tools"]);
  const more = screen.getByRole("button", { name: "More map tools" });
  expect(more.getAttribute("aria-expanded")).toBe("false");
  await fireEvent.click(more);
  expect(more.getAttribute("aria-expanded")).toBe("true");
  expect(names()).toHaveLength(8);
  expect(names()).toContain("Legend");
  await fireEvent.click(more);
  await tick();
  expect(names()).toHaveLength(3);
});
