import { describe, expect, it } from "vitest";
import { found, type Searched } from "./search";

describe("search", () => {
  const places = ["Ward 10", "Ward 2", "Nurses' station", "Café", "Staff room"].map((name) => ({ name }));
  const names = (search: string): string[] => found(places, search).map(({ name }) => name);

  it("finds by any part of the name, whatever its accents", () => {
    expect(names("cafe")).toEqual(["Café"]);
    expect(names("sta")).toEqual(["Staff room", "Nurses' station"]);
    expect(names("nurses’ st")).toEqual(["Nurses' station"]);
  });

  it.each([
    ["ward2", "Ward 2"],
    ["Station 10", "Ward 10"],
    ["aufzug", "Lift A"],
    ["elevator", "Lift A"],
    ["cafetria", "Cafeteria"],
    ["phramacy", "Pharmacy"],
    ["cafeterria", "Cafeteria"],
    ["Apotheke", "Pharmacy"],
    ["labor", "Laboratory"],
    ["Speisesaal", "Cafeteria"], // as the map itself says in German
  ])("forgives %s", (search, name) => {
    const map = ["Ward 1", "Ward 2", "Ward 10", "Lift A", "Pharmacy", "Laboratory"].map((each): Searched => ({ name: each }));
    expect(found([...map, { name: "Cafeteria", names: { de: "Speisesaal" } }], search).map((each) => each.name)).toEqual([name]);
  });

  it("never takes one figure for another", () => {
    expect(names("ward 3")).toEqual([]);
    expect(names("ward 22")).toEqual([]);
  });

  it("orders numbers as people do", () => {
    expect(names("ward")).toEqual(["Ward 2", "Ward 10"]);
    expect(names("nowhere")).toEqual([]);
  });
});
