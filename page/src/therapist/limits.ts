// Limits and settings with their bounds, and the comparison "looser than before".

import { languageNow, t, type Key } from "../i18n/text.svelte";
import type { ChairInfo, Limits, RiderSettings } from "../messages";

/** Result of a change in words. */
export interface Outcome {
  readonly done: boolean;
  readonly text: string;
}

/** A number that the therapist sets. */
export interface Quantity<Name extends string> {
  readonly name: Name;
  readonly label: Key;
  readonly about: Key;
  readonly unit: string;
  readonly least: number;
  readonly most: number;
  readonly step: number;
  /** Direction that allows the chair more; 0: neither. */
  readonly looser: 1 | -1 | 0;
}

export const LIMITS: readonly Quantity<keyof Limits>[] = [
  {
    name: "max_speed", label: "limit.speed", about: "limit.speed.about",
    unit: "m/s", least: 0.1, most: 3, step: 0.05, looser: 1,
  },
  {
    name: "max_acceleration", label: "limit.acceleration", about: "limit.acceleration.about",
    unit: "m/s²", least: 0.1, most: 2, step: 0.05, looser: 1,
  },
  {
    name: "min_distance", label: "limit.distance", about: "limit.distance.about",
    unit: "m", least: 0, most: 2, step: 0.05, looser: -1,
  },
];

/** Settings that are numbers. */
export type RiderNumber = Exclude<keyof RiderSettings, "start_at_once" | "switches">;

export const RIDER: readonly Quantity<RiderNumber>[] = [
  {
    name: "tremor_filter", label: "rider.tremor", about: "rider.tremor.about",
    unit: "s", least: 0, most: 1, step: 0.05, looser: 0,
  },
  {
    name: "dead_zone", label: "rider.deadZone", about: "rider.deadZone.about",
    unit: "", least: 0, most: 0.6, step: 0.01, looser: 0,
  },
  {
    name: "dwell", label: "rider.dwell", about: "rider.dwell.about",
    unit: "s", least: 0.3, most: 5, step: 0.1, looser: 0,
  },
];

type Bounds = Pick<ChairInfo, "max_speed" | "max_acceleration">;

/** The limits, no further than this chair goes. */
export function limitsOf(chair: Bounds | undefined): typeof LIMITS {
  return LIMITS.map((q) => {
    const top = q.name === "min_distance" ? Infinity : (chair?.[q.name] ?? Infinity);
    return { ...q, most: Math.max(q.least, Math.min(q.most, top)) };
  });
}

/** What a preset's limits become on this chair, which may be slower than the one they were made for. */
export function onChair(limits: Limits, chair: Bounds | undefined): Limits {
  const held = limitsOf(chair).map(({ name, most }) => [name, Math.min(limits[name], most)]);
  return Object.fromEntries(held) as unknown as Limits;
}

/** Message for limits that were sent, given those now in force. */
export function told(sent: Limits, now: Limits): string {
  return isSame(LIMITS, sent, now) ? t("limits.saved") : t("limits.bounded");
}

/** Applied values of the changed quantities: "Maximum speed 0.6 m/s, …". */
export function inForce<Name extends string>(
  quantities: readonly Quantity<Name>[],
  changed: Readonly<Partial<Record<Name, number>>>,
  now: Readonly<Record<Name, number>>,
): string {
  const said = quantities
    .filter(({ name }) => changed[name] !== undefined)
    .map(({ name, label, unit }) => `${t(label)} ${figure(now[name])}${unit && ` ${unit}`}`);
  return t("limits.applied", { what: said.join(", ") });
}

/** True if both have the same values of these quantities; what is not known is like nothing. */
export function alike<Name extends string>(
  quantities: readonly Quantity<Name>[],
  one: Readonly<Record<Name, number>>,
  other: Readonly<Record<Name, number>> | null,
): boolean {
  return other !== null && quantities.every(({ name }) => one[name] === other[name]);
}

/** A number as the reader's language writes it, with as many digits as were set. */
export function figure(value: number): string {
  return value.toLocaleString(languageNow(), { maximumFractionDigits: 3 });
}

/** Why a value cannot be set; empty: it can. */
export function fault(quantity: Quantity<string>, value: number): string {
  if (!Number.isFinite(value)) return t("limits.noNumber");
  if (value >= quantity.least && value <= quantity.most) return "";
  const unit = quantity.unit && ` ${quantity.unit}`;
  return t("limits.between", { least: figure(quantity.least), most: `${figure(quantity.most)}${unit}` });
}

/** True if any new value allows the chair more than now. */
export function isLooser<Name extends string>(
  quantities: readonly Quantity<Name>[],
  now: Readonly<Record<Name, number>>,
  next: Readonly<Record<Name, number>>,
): boolean {
  return quantities.some(({ name, looser }) => looser * (next[name] - now[name]) > 0);
}

export function isSame<Name extends string>(
  quantities: readonly Quantity<Name>[],
  now: Readonly<Record<Name, number>>,
  next: Readonly<Record<Name, number>>,
): boolean {
  return quantities.every(({ name }) => now[name] === next[name]);
}
