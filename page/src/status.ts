// The reason on display and the line about a standing chair, for the components that show them.

import { chair } from "./chair.svelte";
import { serverText } from "./i18n/text.svelte";
import type { ChairState } from "./messages";
import { ASKED, holdsTrip } from "./reasonDisplay";
import { steererOf } from "./share";
import { standing } from "./standing";
import { surroundings } from "./surroundings.svelte";
import { trip } from "./trip.svelte";
import { causeWords, firstSentence, observed, reasonWords, type Audience } from "./words";

/** The reason on display; empty: there is none. */
export function reasonNow(audience: Audience = "rider"): string {
  const { saying, cause } = surroundings;
  return saying.shown ? reasonWords(saying.shown, cause, chair.state?.rate ?? 1, audience) : "";
}

/** Reasons of speed, which do not explain a stand. */
const OF_SPEED = new Set(["over_limits", "creeping"]);

/** What holds a standing chair although nothing is on display; empty: no words; null: nothing does. */
function heldWords(audience: Audience): string | null {
  const { reason, cause } = surroundings.held ?? {};
  // What a button asked for is done: the chair sets off.
  if (!reason || ASKED.has(reason.code)) return null;
  if (cause) return causeWords(cause, audience);
  return OF_SPEED.has(reason.code) ? "" : firstSentence(audience === "observer" ? observed(reason) : serverText(reason.text));
}

/** True while a fault holds the chair, so that nothing is told of the way. */
export function faultHolds(): boolean {
  const { shown } = surroundings.saying;
  return holdsTrip(shown?.code ?? "", chair.state?.not_ready ?? null);
}

/** True once the trip is over, although the chair may still roll out; false if the rider steers on. */
function hasArrived(state: ChairState): boolean {
  if (state.arrived) return true;
  return chair.arrival !== null && !state.goal && steererOf(state.rider_authority) === "chair";
}

/** Why the chair stands; empty while it drives. */
export function standingNow(audience: Audience = "rider"): string {
  const state = chair.stale ? null : chair.displayedState;
  if (state && !surroundings.stands && !hasArrived(state)) return "";
  return standing({
    state,
    audience,
    driving: chair.driving,
    why: reasonNow(audience),
    held: heldWords(audience),
    close: surroundings.close ? causeWords(surroundings.close, audience) : "",
    code: surroundings.saying.shown?.code ?? "",
    arrival: chair.arrival?.name ?? null,
    startable: trip.startable,
    planned: chair.route.points.length > 0,
    error: chair.route.error ?? "",
  });
}
