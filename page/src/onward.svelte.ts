// A trip to another storey: to a lift, with the rider's word onto the other map, and on to the place.

import { chair } from "./chair.svelte";
import { t } from "./i18n/text.svelte";
import { selection } from "./mapSelection.svelte";
import { distance } from "./map/strokes";
import type { StoreyInfo } from "./messages";
import { trip } from "./trip.svelte";

export interface Onward {
  readonly place: string;
  readonly storey: string;
  /** Place on the present storey at which a lift leads there. */
  readonly lift: string;
}

/** After this time without a trip to the lift it was cancelled, ms: a goal takes a moment to be in force. */
const GONE = 3_000;

class OnwardTrip {
  to = $state.raw<Onward | null>(null);
  /** When the trip to the lift was last there, as a draft, under way, or at its end, ms. */
  #there = 0;

  /** Storeys of the building but the present one. */
  readonly others = $derived<readonly StoreyInfo[]>((chair.scene?.storeys ?? []).filter((each) => each.name !== chair.scene?.storey));

  /** Where the chair stands at the lift, and waits for the rider's word. */
  readonly there = $derived(
    this.to !== null && chair.status === "open" && chair.goal === null && !trip.open && chair.arrival?.name === this.to.lift,
  );

  /** Opens the overview of the trip to the nearest lift that leads to a storey. */
  choose(place: string, storey: StoreyInfo): void {
    const [x = 0, y = 0] = chair.state?.pose ?? [];
    const lifts = (storey.lifts ?? []).map((name) => chair.placeName(name));
    const [lift] = (chair.scene?.places ?? [])
      .filter(({ name }) => lifts.includes(name))
      .sort((a, b) => distance([a.x, a.y], [x, y]) - distance([b.x, b.y], [x, y]));
    if (!lift) {
      selection.refusal = t("storey.noLift", { storey: storey.name });
      return;
    }
    this.to = { place, storey: storey.name, lift: lift.name };
    this.#there = performance.now();
    void trip.choose({ place: lift.name }, lift.name);
  }

  /** The rider says that the chair is on the other storey. */
  arrive(): void {
    if (this.to) void selection.ask({ type: "change_storey", storey: this.to.storey });
  }

  cancel(): void {
    this.to = null;
  }

  /** Looks, from time to time, whether the chair is on that storey, or its trip to the lift has ended. */
  look(now = performance.now()): void {
    const { to } = this;
    if (!to || !chair.state) return;
    const names = [trip.draft?.name, chair.goal?.name];
    if (chair.scene?.storey === to.storey) {
      this.to = null;
      void trip.choose({ place: to.place }, chair.placeName(to.place));
    } else if (names.some((name) => name !== undefined && name !== to.lift)) {
      this.to = null;
    } else if (trip.draft || chair.goal || chair.arrival?.name === to.lift) {
      this.#there = now;
    } else if (now - this.#there > GONE) {
      this.to = null;
    }
  }
}

export const onward = new OnwardTrip();
