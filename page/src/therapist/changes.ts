// What may be changed, within which bounds, and what is looser than before.

import type { Chair, Limits, RiderSettings } from "../messages";

/** What came of a change, in words. */
export interface Outcome {
  readonly done: boolean;
  readonly text: string;
}

/** A number that the therapist sets. */
export interface Quantity<Name extends string> {
  readonly name: Name;
  readonly label: string;
  readonly about: string;
  readonly unit: string;
  readonly least: number;
  readonly most: number;
  readonly step: number;
  /** Which way lets the chair do more; 0: neither. */
  readonly looser: 1 | -1 | 0;
}

export const LIMITS: readonly Quantity<keyof Limits>[] = [
  {
    name: "max_speed", label: "Greatest speed", about: "The chair never drives faster.",
    unit: "m/s", least: 0.1, most: 3, step: 0.05, looser: 1,
  },
  {
    name: "max_acceleration", label: "Greatest acceleration",
    about: "How quickly it may become faster. Braking is never limited.",
    unit: "m/s²", least: 0.1, most: 2, step: 0.05, looser: 1,
  },
  {
    name: "min_distance", label: "Least distance from people", about: "Kept in every mode but “By hand”.",
    unit: "m", least: 0, most: 2, step: 0.05, looser: -1,
  },
];

export const RIDER: readonly Quantity<keyof RiderSettings>[] = [
  {
    name: "tremor_filter", label: "Tremor filter",
    about: "Smooths the stick; 0 is off. More makes the chair answer later.",
    unit: "s", least: 0, most: 1, step: 0.05, looser: 0,
  },
  {
    name: "dead_zone", label: "Dead zone", about: "How far the stick moves before it counts, of its whole way.",
    unit: "", least: 0, most: 0.6, step: 0.01, looser: 0,
  },
  {
    name: "dwell", label: "Dwell of the switch", about: "How long each choice stays lit.",
    unit: "s", least: 0.3, most: 5, step: 0.1, looser: 0,
  },
];

/** The limits, no further than this chair goes. */
export function limitsOf(chair: Pick<Chair, "max_speed"> | undefined): typeof LIMITS {
  const top = chair?.max_speed ?? Infinity;
  return LIMITS.map((q) => (q.name === "max_speed" ? { ...q, most: Math.max(q.least, Math.min(q.most, top)) } : q));
}

/** What to say of limits that were sent and those that are in force since. */
export function told(sent: Limits, now: Limits): string {
  return isSame(LIMITS, sent, now) ? "Saved." : "Saved, as far as the chair can.";
}

/** What is in force of what was changed: "Greatest speed 0.6 m/s, …". */
export function inForce<Name extends string>(
  quantities: readonly Quantity<Name>[],
  changed: Readonly<Partial<Record<Name, number>>>,
  now: Readonly<Record<Name, number>>,
): string {
  const said = quantities
    .filter(({ name }) => changed[name] !== undefined)
    .map(({ name, label, unit }) => `${label} ${now[name]}${unit && ` ${unit}`}`);
  return `In force: ${said.join(", ")}.`;
}

/** Why a value cannot be set; empty: it can. */
export function fault(quantity: Quantity<string>, value: number): string {
  if (!Number.isFinite(value)) return "A number is missing.";
  if (value >= quantity.least && value <= quantity.most) return "";
  const unit = quantity.unit && ` ${quantity.unit}`;
  return `Between ${quantity.least} and ${quantity.most}${unit}.`;
}

/** Whether any of the new values would let the chair do more than now. */
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
