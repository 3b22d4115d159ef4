// Texts of the therapist view: numbers, rides, log entries.

import { MEASURES, type MeasureName } from "../measures";
import type { ChairState } from "../messages";
import { isKey, languageNow, num, t, type Key } from "../i18n/text.svelte";
import { reasonNow } from "../status";
import { goalName, metres, modeName, type Mode } from "../words";
import type { AuditEntry, RideSummary } from "./api";

export interface Measure {
  readonly key: string;
  readonly name: string;
  readonly value: string;
  /** Technical term, explained; empty where the name says it all. */
  readonly term: string;
}

/** Measures that a therapist reads, in this order; units are those of every report, the words plain. */
const SHOWN: readonly MeasureName[] = [
  "min_distance",
  "mean_distance",
  "encounters",
  "collisions_person",
  "collisions_wall",
  "wall_distance",
  "social_space_intrusion_share",
  "stalled_time",
  "acceleration_max",
  "jerk_felt_rms",
  "authority",
  "agreement",
  "intervention_share",
  "conflict_share",
  "rider_effort",
  "rider_reversals",
  "preference_distance",
  "spl",
];

/** Whether the measures, the map and the timeline of a ride are still to come. */
export function beingMeasured({ measures, error }: Pick<RideSummary, "measures" | "error">): boolean {
  return error === "" && Object.keys(measures).length === 0;
}

/** Measures of a ride that have a value, in reading order. */
export function measuresOf(ride: Pick<RideSummary, "measures">): Measure[] {
  return SHOWN.flatMap((key) => {
    const value = ride.measures[key];
    if (value === undefined || value === null) return [];
    const { unit } = MEASURES[key];
    return [{ key, name: t(`measure.${key}` as Key), value: inUnit(value, unit), term: termOf(key) }];
  });
}

/** A figure of two sessions, in words; empty where none of the rides has it. */
export interface Compared {
  readonly name: string;
  readonly values: readonly [string, string];
}

/** The figures of two sessions: numbers of rides and stops, and means over the rides that have them. */
export function compared(one: readonly RideSummary[], other: readonly RideSummary[]): Compared[] {
  const both = [one, other] as const;
  const row = (name: string, of: (rides: readonly RideSummary[]) => string): Compared => ({
    name, values: [of(both[0]), of(both[1])],
  });
  const averaged = (name: string, of: (ride: RideSummary) => number | null | undefined, words: (mean: number) => string): Compared =>
    row(name, (rides) => {
      const known = rides.map(of).filter((each): each is number => each !== null && each !== undefined);
      return known.length > 0 ? words(known.reduce((sum, each) => sum + each, 0) / known.length) : "";
    });
  const measures = SHOWN.map((key) =>
    averaged(t(`measure.${key}` as Key), ({ measures }) => measures[key], (mean) => inUnit(mean, MEASURES[key].unit)),
  );
  return [
    row(t("compare.rides"), (rides) => num(rides.length, 0)),
    row(t("compare.arrived"), (rides) => num(rides.filter(({ outcome }) => outcome === "arrived").length, 0)),
    averaged(t("ride.time"), (ride) => ride.duration, duration),
    averaged(t("ride.distance"), (ride) => ride.length, metres),
    averaged(t("ride.stops"), (ride) => ride.stops.length, (mean) => num(mean, 1)),
    averaged(t("ride.rating"), (ride) => ride.rating, (mean) => t("ride.of5", { n: num(mean, 1) })),
    ...measures.filter(({ values }) => values.some(Boolean)),
  ];
}

function termOf(key: MeasureName): string {
  const term = `measure.${key}.term`;
  return isKey(term) ? t(term) : "";
}

function inUnit(value: number, unit: string): string {
  if (unit === "%") return `${num(100 * value, 0)} %`;
  if (unit === "s") return duration(value);
  const text = num(value, Number.isInteger(value) && unit === "" ? 0 : 2);
  return unit ? `${text} ${unit}` : text;
}

export function duration(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole < 60) return t("unit.seconds", { n: whole });
  return t("unit.minutesSeconds", { minutes: Math.floor(whole / 60), seconds: whole % 60 });
}

/** A time of the server's, as the reader's clock and language have it. */
export function moment(iso: string, locale: string = languageNow(), timeZone?: string): string {
  const time = new Date(iso);
  if (Number.isNaN(time.getTime())) return iso;
  const zone = timeZone === undefined ? {} : { timeZone };
  return time.toLocaleString(locale, { dateStyle: "medium", timeStyle: "medium", ...zone });
}

/** Time of day, as in the log. */
export function clock(iso: string, locale: string = languageNow(), timeZone?: string): string {
  const time = new Date(iso);
  if (Number.isNaN(time.getTime())) return iso;
  const zone = timeZone === undefined ? {} : { timeZone };
  return time.toLocaleTimeString(locale, { timeStyle: "short", ...zone });
}

/** A ride without a destination is on no way to be left: it ends. */
export function outcome(ride: Pick<RideSummary, "outcome" | "destination">): string {
  if (ride.outcome === "cancelled" && !ride.destination) return t("outcome.ended");
  return isKey(`outcome.${ride.outcome}`) ? t(`outcome.${ride.outcome}`) : ride.outcome;
}

/** Target of a ride's distance from people that somebody came closer than; null: nobody did. */
export function breach(ride: Pick<RideSummary, "limits" | "measures" | "nearest">): { nearest: number; target: number } | null {
  const nearest = ride.measures["min_distance"] ?? ride.nearest ?? undefined;
  if (nearest === undefined || ride.limits.length === 0) return null;
  const target = Math.max(...ride.limits.map((each) => each.limits.min_distance));
  return nearest < target - 0.005 ? { nearest, target } : null;
}

/** Mean jolts up to which a ride is calm, and up to which they are some, m/s³: the aim of docs/calm.md, and twice it (assumed). */
const CALM = 1;
const SOME = 2;

/** How a ride felt; null: it is not known. */
export function feeling({ measures }: Pick<RideSummary, "measures">): "calm" | "some" | "jerky" | null {
  const jolts = measures["jerk_felt_rms"];
  if (jolts === undefined || jolts === null) return null;
  if (jolts <= CALM) return "calm";
  return jolts <= SOME ? "some" : "jerky";
}

export function destination(ride: Pick<RideSummary, "destination">): string {
  return ride.destination || t("outcome.noDestination");
}

/** "shared 2 min 5 s, manual 12 s", the longest first. */
export function shares(times: Readonly<Record<string, number>>): string {
  const used = Object.entries(times).filter(([, time]) => time >= 0.5);
  if (used.length === 0) return t("none");
  return used
    .sort((a, b) => b[1] - a[1])
    .map(([name, time]) => `${nameOf(name)} ${duration(time)}`)
    .join(", ");
}

function nameOf(name: string): string {
  if (isKey(`mode.${name}`)) return modeName(name as Mode).toLowerCase();
  return isKey(`device.${name}`) ? t(`device.${name}` as Key) : name;
}

export function what(entry: Pick<AuditEntry, "event">): string {
  return isKey(`audit.${entry.event}`) ? t(`audit.${entry.event}` as Key) : entry.event.replaceAll("_", " ");
}

/** Who did it: the chair, somebody signed in, or a page by its number. */
export function who({ actor }: Pick<AuditEntry, "actor">): string {
  const [, kind, number] = /^(chair|driver|page|therapist)(?:[- ](.+))?$/.exec(actor) ?? [];
  return kind ? [t(`audit.actor.${kind}` as Key), number ?? ""].join(" ").trim() : actor;
}

/** Details of an entry in one line; with a before and an after, the difference. */
export function details(said: Readonly<Record<string, unknown>>): string {
  const { before, after, ...rest } = said;
  const changes = isObject(before) && isObject(after) ? changed(before, after) : [];
  const others = changes.length > 0 || (!before && !after) ? rest : said;
  const told = Object.entries(others).map(([name, value]) => `${spaced(name)}: ${shown(value)}`);
  return [...changes, ...told].join(", ");
}

function changed(before: Record<string, unknown>, after: Record<string, unknown>): string[] {
  return Object.keys(after)
    .filter((name) => shown(before[name]) !== shown(after[name]))
    .map((name) => `${spaced(name)}: ${shown(before[name])} → ${shown(after[name])}`);
}

function shown(value: unknown): string {
  if (value === null || value === undefined) return t("none");
  if (typeof value === "number") return String(Math.round(1000 * value) / 1000);
  if (typeof value === "string" || typeof value === "boolean") return String(value);
  if (Array.isArray(value)) return `(${value.map(shown).join(", ")})`;
  return Object.entries(value).map(([name, each]) => `${spaced(name)} ${shown(each)}`).join(", ");
}

function isObject(value: unknown): value is Record<string, unknown> {
  return value !== null && typeof value === "object" && !Array.isArray(value);
}

function spaced(name: string): string {
  return name.replaceAll("_", " ");
}

/** Driver and device in words. */
export function driver(state: ChairState | null): string {
  if (!state) return t("who.notConnected");
  if (!state.driver) return t("who.noDriver");
  const device = state.device ?? "none";
  return device === "none" ? t("now.noInput") : t("now.withDevice", { device: t(`device.${device}`) });
}

/** What a moving chair does, and what slows it down. */
export function doing(state: ChairState | null): string {
  if (!state) return "—";
  const drives = state.goal ? t("watch.drivingTo", { name: goalName(state.goal) }) : t("watch.driving");
  const why = reasonNow("observer");
  return why ? `${drives}. ${why}` : drives;
}
