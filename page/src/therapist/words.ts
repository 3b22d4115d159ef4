// Texts of the therapist view: numbers, rides, log entries.

import { MEASURES, type MeasureName } from "../measures";
import type { ChairState } from "../messages";
import { MODES } from "../words";
import type { AuditEntry, RideSummary } from "./api";

export interface Measure {
  readonly key: string;
  readonly name: string;
  readonly value: string;
}

/** Measures that a therapist reads, in this order; labels and units are those of every report. */
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
  "jerk_rms",
  "authority",
  "agreement",
  "intervention_share",
  "conflict_share",
  "rider_effort",
  "rider_reversals",
  "preference_distance",
  "spl",
];

/** Measures of a ride that have a value, in reading order. */
export function measuresOf(ride: Pick<RideSummary, "measures">): Measure[] {
  return SHOWN.flatMap((key) => {
    const value = ride.measures[key];
    if (value === undefined || value === null) return [];
    const { label, unit } = MEASURES[key];
    const name = label.charAt(0).toUpperCase() + label.slice(1);
    return [{ key, name, value: inUnit(value, unit) }];
  });
}

function inUnit(value: number, unit: string): string {
  if (unit === "%") return `${(100 * value).toFixed(0)} %`;
  if (unit === "s") return duration(value);
  const text = Number.isInteger(value) && unit === "" ? value.toFixed(0) : value.toFixed(2);
  return unit ? `${text} ${unit}` : text;
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

const OUTCOMES = { arrived: "Arrived", cancelled: "Ended before arrival", collision: "Collision" };

/** A ride without a destination is on no way to be left: it ends. */
export function outcome(ride: Pick<RideSummary, "outcome" | "destination">): string {
  if (ride.outcome === "cancelled" && !ride.destination) return "Ended";
  return OUTCOMES[ride.outcome] ?? ride.outcome;
}

export function destination(ride: Pick<RideSummary, "destination">): string {
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
  drive_started: "The server was started",
  drive_closed: "The server was closed",
  signed_in: "Signed in",
  sign_in_rejected: "Tried to sign in with a wrong token",
  signed_out: "Signed out",
  connected: "Opened a page",
  disconnected: "Left",
  control_taken: "Took control",
  control_released: "Gave up control",
  stop_pressed: "Pressed STOP",
  resumed: "Continued",
  limits_changed: "Changed the limits",
  limits_rejected: "Looser limits refused",
  rider_settings_changed: "Changed the rider’s settings",
  mode_changed: "Changed the mode",
  pace_changed: "Changed the pace",
  goal_changed: "Chose a destination",
  simulation_changed: "Changed the simulation",
  simulation_restarted: "Restarted",
  navigator_lost: "The navigator was lost",
  rejected: "Request refused",
  sessions_deleted: "Deleted the sessions",
  session_exported: "Exported a session",
  entries_dropped: "Entries could not be written",
};

export function what(entry: Pick<AuditEntry, "event">): string {
  return WHAT[entry.event] ?? entry.event.replaceAll("_", " ");
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

/** Driver and device in words. */
export function driver(state: ChairState | null): string {
  if (!state) return "Not connected";
  if (!state.driver) return "No driver";
  const device = DEVICES[state.device];
  return device ? `The rider, with the ${device}` : "The rider, no input";
}

const LINKS: Readonly<Record<ChairState["link"], string>> = {
  no_driver: "No driver",
  no_heartbeat: "The rider’s screen is not connected",
  stick_held: "Stopped; the stick is still held",
  centre_stick: "Waiting for the stick to be released",
  confirm: "Waiting for “Go on”",
  ready: "Free to move",
};

/** ChairState of the chair and its reason in words. */
export function doing(state: ChairState | null): string {
  if (!state) return "—";
  if (state.paused) return "The simulation is paused";
  if (state.reason) return state.reason.text;
  return LINKS[state.link];
}
