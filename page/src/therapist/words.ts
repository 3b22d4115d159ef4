// How numbers, rides and entries of the log are said to the therapist.

import type { State } from "../messages";
import { MODES } from "../words";
import type { Entry, RideRecord } from "./api";

export interface Measure {
  readonly key: string;
  readonly name: string;
  readonly value: string;
}

type Unit = "s" | "m" | "share" | "m/s²" | "m/s³" | "1/min" | "count" | "number";

const MEASURES: readonly (readonly [string, string, Unit])[] = [
  ["min_distance", "Least distance from a person", "m"],
  ["mean_distance", "Mean distance from the nearest person", "m"],
  ["encounters", "People met within 2 m", "count"],
  ["collisions_person", "People touched by the moving chair", "count"],
  ["collisions_wall", "Walls touched", "count"],
  ["wall_distance", "Least distance from a wall", "m"],
  ["social_space_intrusion_share", "Time in somebody’s space", "share"],
  ["stalled_time", "Time standing on the way", "s"],
  ["acceleration_max", "Greatest acceleration or braking", "m/s²"],
  ["jerk_rms", "Jerk, root mean square", "m/s³"],
  ["authority", "The rider’s share in steering", "share"],
  ["agreement", "Agreement of what was asked and done, −1 to 1", "number"],
  ["intervention_share", "Time in which the chair did otherwise than asked", "share"],
  ["fight_rate", "Time in which the chair turned the other way", "share"],
  ["rider_effort", "Movement of the stick, in full deflections", "number"],
  ["rider_reversals", "Changes of the stick’s direction", "1/min"],
  ["preference_distance", "Greatest distance from the wishes", "m"],
  ["spl", "Shortness of the way, 1 is the shortest", "number"],
];

/** A ride's measures that have a meaning here, in the order in which they are read. */
export function measuresOf(ride: Pick<RideRecord, "measures">): Measure[] {
  return MEASURES.flatMap(([key, name, unit]) => {
    const value = ride.measures[key];
    return value === undefined || value === null ? [] : [{ key, name, value: inUnit(value, unit) }];
  });
}

function inUnit(value: number, unit: Unit): string {
  if (unit === "share") return `${(100 * value).toFixed(0)} %`;
  if (unit === "count") return value.toFixed(0);
  if (unit === "number") return value.toFixed(2);
  if (unit === "s") return duration(value);
  return `${value.toFixed(unit === "1/min" ? 1 : 2)} ${unit}`;
}

export function duration(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  return `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

/** A time of the server's, as the reader's clock and language have it. */
export function moment(iso: string, locale?: string, timeZone?: string): string {
  const time = new Date(iso);
  if (Number.isNaN(time.getTime())) return iso;
  const zone = timeZone === undefined ? {} : { timeZone };
  return time.toLocaleString(locale, { dateStyle: "medium", timeStyle: "medium", ...zone });
}

const OUTCOMES = { arrived: "Arrived", left: "Left on the way", collision: "Touched something" };

/** A ride without a destination is on no way to be left: it ends. */
export function outcome(ride: Pick<RideRecord, "outcome" | "destination">): string {
  if (ride.outcome === "left" && !ride.destination) return "Ended";
  return OUTCOMES[ride.outcome] ?? ride.outcome;
}

export function destination(ride: Pick<RideRecord, "destination">): string {
  return ride.destination || "no destination";
}

/** "shared 2 min 5 s, manual 12 s", the longest first. */
export function shares(times: Readonly<Record<string, number>>): string {
  const used = Object.entries(times).filter(([, time]) => time >= 0.5);
  if (used.length === 0) return "none";
  return used
    .sort((a, b) => b[1] - a[1])
    .map(([name, time]) => `${nameOf(name)} ${duration(time)}`)
    .join(", ");
}

function nameOf(name: string): string {
  return (name in MODES ? MODES[name as keyof typeof MODES].name : name).toLowerCase();
}

const WHAT: Readonly<Record<string, string>> = {
  started: "The server was started",
  closed: "The server was closed",
  signed_in: "Signed in",
  sign_in_refused: "Tried to sign in with a wrong token",
  signed_out: "Signed out",
  joined: "Opened a page",
  left: "Left",
  took: "Took control",
  released: "Gave up control",
  stop: "Pressed STOP",
  resume: "Went on",
  limits: "Changed the limits",
  limits_refused: "Was refused looser limits",
  rider: "Changed the rider’s settings",
  mode: "Changed the mode",
  pace: "Changed the pace",
  goal: "Chose a destination",
  simulated: "Changed the simulation",
  restarted: "Restarted",
  navigator_lost: "The navigator was lost",
  refused: "Was refused",
  deleted: "Deleted the sessions",
  exported: "Exported a session",
  dropped: "Entries could not be written",
};

export function what(entry: Pick<Entry, "what">): string {
  return WHAT[entry.what] ?? entry.what.replaceAll("_", " ");
}

/** What belongs to an entry, in one line; where there is a before and an after, what differs. */
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
  if (value === null || value === undefined) return "none";
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

const DEVICES = { none: "", joystick: "joystick", gamepad: "gamepad", keys: "keys", switch: "switch" };

/** Who drives and with what, in words. */
export function driver(state: State | null): string {
  if (!state) return "Not connected";
  if (!state.driver) return "Nobody drives";
  const device = DEVICES[state.device];
  return device ? `The rider, with the ${device}` : "The rider, hands off";
}

const LINKS: Readonly<Record<State["link"], string>> = {
  nobody: "Nobody drives",
  silent: "The rider’s page is silent",
  stopped: "Stopped; the stick is still held",
  centre: "Waits for the stick to be let go",
  confirm: "Stands until the rider goes on",
  ready: "Nothing holds it",
};

/** What the chair does and why, in words. */
export function doing(state: State | null): string {
  if (!state) return "—";
  if (state.paused) return "The simulation is paused";
  if (state.why) return state.why.text;
  return LINKS[state.link];
}
