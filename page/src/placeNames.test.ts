import { afterEach, describe, expect, it } from "vitest";
import { Chair } from "./chair.svelte";
import { chooseLanguage } from "./i18n/text.svelte";
import type { ChairState, Welcome } from "./messages";

const places = [
  { name: "Ward 2", x: 1, y: 2, area: [], names: { de: "Station 2" } },
  { name: "Store", x: 3, y: 4, area: [], names: {} },
];

describe("places", () => {
  afterEach(() => chooseLanguage("en"));

  it("have their name in the page's language wherever the page says it", () => {
    const chair = new Chair();
    chair.heard({ type: "welcome", client: "a", role: "driver", scene: { places } } as unknown as Welcome);
    const state = { type: "state", goal: { name: "Ward 2", x: 1, y: 2 }, offers: [{ name: "Ward 2" }] } as unknown as ChairState;
    chair.heard(state);
    expect([chair.scene!.places[0]!.name, chair.goal!.name]).toEqual(["Ward 2", "Ward 2"]);
    chooseLanguage("de");
    chair.heard(state);
    expect(chair.scene!.places.map(({ name }) => name)).toEqual(["Station 2", "Store"]);
    expect([chair.goal!.name, chair.state!.offers[0]!.name]).toEqual(["Station 2", "Station 2"]);
    expect(["Ward 2", "Station 2", "Store", "gone"].map((name) => chair.placeName(name))).toEqual(["Station 2", "Station 2", "Store", "gone"]);
  });
});
