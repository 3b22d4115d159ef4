// @vitest-environment node
import { describe, expect, it } from "vitest";
import { grouped, kindOf, recentAfter, toggled } from "./places";

const named = (...names: string[]): { name: string }[] => names.map((name) => ({ name }));

describe("places", () => {
  it("are each in one group, wards first", () => {
    const places = named("Cafeteria", "Ward 1", "WC east", "Bathroom 2", "Nurses' station", "Lift A", "Day room", "Kitchen");
    const groups = grouped(places).map(({ title, places }) => [title, places.map(({ name }) => name)]);
    expect(groups).toEqual([
      ["places.wards", ["Ward 1"]],
      ["places.toilets", ["WC east", "Bathroom 2"]],
      ["places.food", ["Cafeteria", "Kitchen"]],
      ["places.care", ["Nurses' station"]],
      ["places.ways", ["Lift A"]],
      ["places.other", ["Day room"]],
    ]);
  });

  it("have a colour by kind; ways between them have none", () => {
    expect(["Ward 1", "Bathroom 2", "Day room"].map(kindOf)).toEqual(["places.wards", "places.toilets", "places.other"]);
    expect(["North corridor", "East passage", "Bed niche", "Flur"].map(kindOf)).toEqual([null, null, null, null]);
  });

  it("are remembered, the newest first, and only a few of them", () => {
    expect(recentAfter(["a", "b", "c", "d"], "c")).toEqual(["c", "a", "b", "d"]);
    expect(recentAfter(["a", "b", "c", "d"], "e")).toEqual(["e", "a", "b", "c"]);
    expect(toggled(["a"], "b")).toEqual(["a", "b"]);
    expect(toggled(["a", "b"], "a")).toEqual(["b"]);
  });
});
