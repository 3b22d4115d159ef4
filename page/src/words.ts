// Texts that depend on values: lengths, times, states. All words are in the catalogue.

import type { Cause } from "./around";
import { en } from "./i18n/en";
import { isKey, num, plural, serverText, t, type Key } from "./i18n/text.svelte";
import { areaOf, contains, farthestFrom } from "./map/strokes";
import type { ChairState, PlaceInfo, ReasonText, RideEnded, RouteDifference, TripRoute } from "./messages";
import type { Turn } from "./turns";

export type Mode = ChairState["mode"];
export type Pace = ChairState["pace"];
export const PACES: readonly Pace[] = ["slow", "normal", "brisk"];

/** Modes in which the chair stands without a hand on the stick. */
export const RIDER_DRIVES: ReadonlySet<Mode> = new Set<Mode>(["assisted", "stop_only", "manual"]);

export function modeName(mode: Mode): string {
  return t(`mode.${mode}`);
}

export interface Readiness {
  readonly text: string;
  /** Message that the button sends; null: something else must be done first. */
  readonly action: "take_control" | "resume" | "start" | null;
  /** Words on the button; empty: there is none. */
  readonly label: string;
  /** True if it is the one thing to do next. */
  readonly main: boolean;
}

type Next = Pick<ChairState, "link" | "driver" | "goal" | "mode" | "arrived" | "reason" | "not_ready">;

/** What else the page knows about the next step. */
export interface Around {
  /** Why there is no route to the destination. */
  readonly trouble?: string;
  /** The overview of a trip is open: the button sets off, and ends a stop, too. */
  readonly start?: {
    readonly words: string;
    /** There is a route to set off on. */
    readonly ready: boolean;
  } | null;
  /** The last trip has arrived, and there is none since. */
  readonly arrived?: boolean;
  /** A fault holds the chair. */
  readonly held?: boolean;
}

/** Next step of the driver before the chair moves. */
export function readiness(state: Next | null, driving: boolean, around: Around = {}): Readiness {
  const goal = state?.arrived ? null : (state?.goal ?? null);
  const label = goal ? t("ready.goOnTo", { name: goalName(goal) }) : t("ready.goOn");
  const first = (text: string): Readiness => ({ text, action: null, label, main: false });
  const take = (text: string): Readiness => ({ text, action: "take_control", label: t("ready.take"), main: true });
  if (!state) return first(t("ready.notConnected"));
  const { start } = around;
  if (start && (driving || !state.driver)) {
    return { text: beforeStart(state, start), action: start.ready ? "start" : null, label: start.words, main: true };
  }
  if (!state.driver) return take(t("ready.noDriver"));
  if (!driving) return take(t("ready.other"));
  switch (state.link) {
    case "stick_held":
      return first(t("ready.stoppedRelease"));
    case "centre_stick":
      // It moves on without a press, so that there is no button.
      return { ...first(t(goal && !RIDER_DRIVES.has(state.mode) ? "ready.movesOn" : "ready.release")), label: "" };
    case "confirm":
      // A confirmation that cannot end the stop is not offered.
      if (state.not_ready) return first(heldWords(state.not_ready));
      return { ...confirmation(goal !== null, around), action: "resume", label };
    case "no_heartbeat":
    case "no_driver":
      return first(t("ready.lost"));
    case "ready":
      // A button without a use reads as a dead one.
      return { text: underWay(state, goal, around), action: null, label: "", main: false };
  }
}

/** What Start waits for, or what it ends. */
function beforeStart({ driver, link, not_ready }: Next, { words, ready }: NonNullable<Around["start"]>): string {
  if (!driver) return t("ready.noDriver");
  if (link === "stick_held" || link === "centre_stick") return t("ready.release");
  if (link !== "confirm") return "";
  if (not_ready) return heldWords(not_ready);
  return ready ? t("ready.confirmStart", { start: words }) : t("ready.stopped");
}

/** "Go on" is the one thing to do, unless a trip is to be chosen: its Start ends the stop, too. */
function confirmation(goal: boolean, { arrived }: Around): Pick<Readiness, "text" | "main"> {
  if (arrived && !goal) return { text: t("ready.confirmArrived"), main: false };
  return { text: t("ready.confirm"), main: true };
}

/** What keeps the chair from going on, and what can be done about it. */
function heldWords({ code, text }: ReasonText): string {
  const key = `hold.${code}`;
  if (isKey(key)) return t(key);
  return t("hold.fault", { why: firstSentence(serverText(text)) });
}

/** What is the case, without what the chair does about it. */
export function firstSentence(text: string): string {
  return text.split(/(?<=\.) /)[0]!;
}

function underWay(state: Next, goal: Next["goal"], { trouble, held }: Around): string {
  if (state.reason?.code === "starting") return t("ready.starting");
  if (!goal) return t("ready.steer");
  return t(trouble ? "ready.noRoute" : held ? "ready.held" : "ready.onTheWay", { name: goalName(goal) });
}

/** Words on the overview's button: what a press does now. */
export function startWords(under: boolean, stands: boolean): string {
  if (!under) return t("trip.start");
  return t(stands ? "trip.startThis" : "trip.changeTo");
}

export function goalName(goal: { readonly name: string }): string {
  return goal.name || t("trip.point");
}

/** Motion of the chair in words; empty: it stands, which the line beside it says with its reason. */
export function movement({ speed, turn_rate }: Pick<ChairState, "speed" | "turn_rate">): string {
  if (Math.abs(speed) >= 0.05) {
    return t(speed < 0 ? "motion.reverse" : "motion.forward", { speed: num(Math.abs(speed), 1) });
  }
  return Math.abs(turn_rate) >= 0.05 ? t("motion.turning") : "";
}

/** A ride that was left after less than this is not asked about, m (assumed). */
const SOME_WAY = 2;

/** True if a finished ride is worth a rating. */
export function memorable(ended: Pick<RideEnded, "outcome" | "length">): boolean {
  return ended.outcome === "collision" || ended.outcome === "fell" || ended.length >= SOME_WAY;
}

export function metres(length: number): string {
  return t("unit.metres", { n: num(length, length < 9.95 ? 1 : 0) });
}

/** "+4.2 m", or "no detour". */
export function detour(extra: number): string {
  if (Math.abs(extra) < 0.05) return t("trip.noDetour");
  return `${extra > 0 ? "+" : "−"}${metres(Math.abs(extra))}`;
}

/** What wishes cost, by their names; more than two are counted. */
export function wishesCost(wishes: readonly { readonly words: string; readonly by?: string }[], extra: number): string {
  const cost = detour(Math.max(0, extra));
  if (wishes.length > 2) return t("trip.wishesCost", { n: wishes.length, detour: cost });
  const names = wishes.map(({ by }) => by ?? "");
  if (names.every(Boolean)) return t("trip.byCost", { names: names.join(", "), detour: cost });
  return t("trip.wishCost", { words: wishes.map(({ words }) => words).join(", "), detour: cost });
}

export function minutes(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole < 60) return t("unit.seconds", { n: whole });
  return t("unit.minutes", { n: `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}` });
}

/** A time to come, no more exact than it is known: "about 40 s", "about 3 min". */
export function roughly(seconds: number): string {
  if (seconds < 8) return t("unit.fewSeconds");
  if (seconds < 95) return t("unit.aboutSeconds", { n: told(seconds) });
  return t("unit.aboutMinutes", { n: Math.round(seconds / 60) });
}

/** A time as it is told, s: the difference of two is that of what one reads. */
function told(seconds: number): number {
  return 5 * Math.round(seconds / 5);
}

/** Less than this is no difference in time, s (assumed). */
const NOTICED = 8;

/** "through North corridor, about 20 s longer, fewer people"; "nearly equal" where nothing is noticed. */
export function compared(
  route: Pick<TripRoute, "points" | "duration" | "differences">,
  first: Pick<TripRoute, "points" | "duration">,
  places: readonly PlaceInfo[],
): string {
  const through = throughName(route.points, first.points, places);
  const more = told(route.duration) - told(first.duration);
  const said = [
    ...(through ? [t("differs.through", { name: through })] : []),
    ...(Math.abs(more) >= NOTICED ? [t(`differs.time.${more > 0 ? "more" : "less"}`, { time: roughly(Math.abs(more)) })] : []),
    ...others(route.differences.filter(({ what }) => what !== "length")),
  ];
  return said.join(", ") || others(route.differences)[0] || t("differs.equal");
}

/** The smallest room or passage in which a route is farthest from another one; empty: it has no name. */
export function throughName(points: TripRoute["points"], other: TripRoute["points"], places: readonly PlaceInfo[]): string {
  const at = farthestFrom(points, other);
  if (!at) return "";
  const around = places.filter(({ area }) => area.length > 2 && contains(area, at));
  return around.sort((a, b) => areaOf(a.area) - areaOf(b.area))[0]?.name ?? "";
}

function others(differences: readonly RouteDifference[]): string[] {
  return differences.map(({ what, more }) => {
    const n = Math.round(Math.abs(more));
    const side = more > 0 ? "more" : "less";
    if (what === "clearance" || what === "encounters") return t(`differs.${what}.${side}`);
    return plural(`differs.${what}.${side}.one`, `differs.${what}.${side}`, n);
  });
}

/** What a passenger is told next. */
export function turnWords(turn: Turn | null, left: number, name: string): string {
  if (!turn) return left < 3 ? t("turn.arriving") : t("turn.straight", { n: roundly(left) });
  const side = turn.side === "left" ? "turn.left" : "turn.right";
  if (turn.after < 2) return t(`${side}.now`);
  return name
    ? t(`${side}.at`, { n: roundly(turn.after), name })
    : t(side, { n: roundly(turn.after) });
}

/** A length to come: to the metre, from 10 m on to five. */
function roundly(length: number): string {
  return num(length < 10 ? Math.round(length) : 5 * Math.round(length / 5), 0);
}

/** Who reads: the rider, who is addressed, or somebody who looks on, as the therapist. */
export type Audience = "rider" | "observer";

/** The reason on display in one sentence or two, with its cause first. */
export function reasonWords(reason: ReasonText, cause: Cause | null, rate: number, audience: Audience = "rider"): string {
  if (reason.code === "navigator_timeout" && rate > 0.95) return t("reason.silent");
  const effect = `effect.${reason.code}`;
  if (cause && isKey(effect)) return `${causeWords(cause, audience)} ${t(worded(effect, audience))}`;
  return audience === "observer" ? observed(reason) : serverText(withoutRequest(reason.text));
}

/** A reason for somebody who looks on. */
export function observed({ code, text }: ReasonText): string {
  const key = `about.reason.${code}`;
  return isKey(key) ? t(key) : serverText(text);
}

/** The key of a text that is worded for an audience; most texts address nobody. */
function worded(key: Key, audience: Audience): Key {
  const about = `about.${key}`;
  return audience === "observer" && isKey(about) ? about : key;
}

/** What the rider must do stands at the button that does it, and nowhere else. */
function withoutRequest(text: string): string {
  const asked = (["reason.confirm", "reason.release_stick"] as const).find((key) => text.endsWith(` ${en[key]}`));
  return asked ? text.slice(0, -en[asked].length).trim() : text;
}

export function causeWords({ thing, moves, name }: Cause, audience: Audience = "rider"): string {
  if (thing === "person") return t(worded(`cause.person.${moves ?? "standing"}`, audience));
  if (thing === "door") return name ? t("cause.door", { name }) : t("cause.someDoor");
  return t(`cause.${thing}`);
}

