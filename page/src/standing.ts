// Why the chair stands, in one line: what holds it, or what it waits for.

import { serverText, t, type Key } from "./i18n/text.svelte";
import type { ChairState } from "./messages";
import { STOPS } from "./reasonDisplay";
import { goalName, RIDER_DRIVES, type Audience } from "./words";

export interface Stand {
  readonly state: Pick<ChairState, "link" | "driver" | "goal" | "mode" | "paused" | "arrived" | "not_ready"> | null;
  readonly audience: Audience;
  /** True if this page drives. */
  readonly driving: boolean;
  /** The reason on display in words, with its cause; empty: there is none. */
  readonly why: string;
  readonly code: string;
  /** The reason of a chair that tells one, or did a moment ago, although none is on display; empty: no words for it; null: there is none. */
  readonly held?: string | null;
  /** What is close ahead; empty: nothing. */
  readonly close?: string;
  /** Name of the destination where the last ride arrived; empty: a point; null: it has not. */
  readonly arrival: string | null;
  /** The overview of a trip is open, and its route may be started. */
  readonly startable: boolean;
  /** Points and error of the route. */
  readonly planned: boolean;
  readonly error: string;
}

/** Reasons that name an action; the line says it shorter. */
const ACTIONS = new Set(["confirm", "release_stick", "no_driver"]);
/** Of no matter to who has arrived. */
const LATE = new Set(["late", "navigator_timeout"]);

export function standing(stand: Stand): string {
  const { state, audience, why, code, startable } = stand;
  if (!state) return t("who.notConnected");
  if (state.paused) return t(audience === "rider" ? "who.paused" : "now.paused");
  // A press on Start answers STOP, too, so it is what the chair waits for.
  const start = startable && !state.goal && !state.not_ready;
  if (start && (!why || STOPS.has(code) || ACTIONS.has(code))) return t("stand.start");
  const over = !state.goal && stand.arrival !== null && LATE.has(code);
  if (why && !ACTIONS.has(code) && !over) return why;
  return t(...waits(stand, state));
}

type Words = [key: Key, values?: Record<string, string>];

/** What a chair without a reason waits for. */
function waits(stand: Stand, state: NonNullable<Stand["state"]>): Words {
  const rider = stand.audience === "rider";
  if (!state.driver) return ["stand.noDriver"];
  if (rider && !stand.driving) return ["stand.other"];
  // "Go on" is not asked for while it cannot end the stop.
  if (state.link === "confirm" && state.not_ready) return ["stand.because", { why: serverText(state.not_ready.text) }];
  // After an arrival the next Start ends the stop, too.
  const arrived = state.link === "confirm" && !state.goal && stand.arrival !== null;
  const held = arrived ? undefined : LINK[state.link];
  if (held) return [rider ? held[0] : held[1]];
  if (state.goal) return towards(stand, state, state.goal);
  if (stand.arrival !== null) return stand.arrival ? ["stand.arrived", { name: stand.arrival }] : ["stand.arrivedPoint"];
  return ["stand.noTrip"];
}

const LINK: Partial<Record<ChairState["link"], readonly [rider: Key, observer: Key]>> = {
  no_driver: ["stand.noDriver", "stand.noDriver"],
  no_heartbeat: ["stand.lost", "watch.lost"],
  stick_held: ["stand.release", "watch.held"],
  centre_stick: ["stand.release", "watch.release"],
  confirm: ["stand.goOn", "watch.goOn"],
};

function towards(stand: Stand, state: NonNullable<Stand["state"]>, goal: { name: string }): Words {
  if (state.arrived) return ["stand.arrived", { name: goalName(goal) }];
  if (stand.error) return ["stand.because", { why: serverText(stand.error) }];
  if (!stand.planned) return ["stand.planning"];
  if (RIDER_DRIVES.has(state.mode)) return [stand.audience === "rider" ? "stand.steer" : "watch.steer"];
  if (stand.held) return ["stand.because", { why: stand.held }];
  if (stand.held === "") return ["stand.moment"];
  return stand.close ? ["stand.offClose", { what: stand.close }] : ["stand.off"];
}
