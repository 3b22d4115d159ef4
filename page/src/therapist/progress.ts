// Progress of a rider: values as text, and dots of a small plot.

import { num, t } from "../i18n/text.svelte";
import type { Quantity, RiderProgress } from "./riders.svelte";

export const QUANTITIES: readonly Quantity[] = ["arrivals", "stops", "effort", "reversals", "near_passes"];
/** Shares, shown as percent. */
const SHARES: ReadonlySet<Quantity> = new Set(["arrivals", "near_passes"]);
export const WIDTH = 240;
export const HEIGHT = 64;
const MARGIN = 6;

export interface Dot {
  readonly x: number;
  readonly y: number;
  /** True if the session was mostly in the mode of the latest one: only these are compared. */
  readonly compared: boolean;
}

export interface Plot {
  readonly name: Quantity;
  readonly title: string;
  readonly unit: string;
  /** What it means, and whether it has a direction. */
  readonly about: string;
  readonly direction: string;
  /** The oldest session first. */
  readonly dots: readonly Dot[];
  /** Sessions with a value may be joined by a line: there are enough of them. */
  readonly joined: boolean;
  readonly top: string;
  readonly latest: string;
  /** Whole content in words. */
  readonly words: string;
}

export function valueText(name: Quantity, value: number | null): string {
  if (value === null) return "–";
  return SHARES.has(name) ? num(100 * value, 0) : num(value, 1);
}

export function plotOf(name: Quantity, progress: RiderProgress): Plot {
  const whole = progress.sessions.map((each) => each.values[name]);
  const known = whole.flatMap((value, k) => (value === null ? [] : [[k, value] as const]));
  const values = known.map(([, value]) => value);
  const top = Math.max(...values, 1); // the whole, for a share
  const across = (WIDTH - 2 * MARGIN) / Math.max(whole.length - 1, 1);
  const mode = progress.sessions.at(-1)?.mode;
  const compared = known.filter(([k]) => progress.sessions[k]?.mode === mode);
  const direction = directionText(progress, name, compared.length);
  const title = t(`progress.${name}`);
  const unit = t(`progress.${name}.unit`);
  const first = valueText(name, values[0] ?? null);
  const last = valueText(name, values.at(-1) ?? null);
  const said = { what: title, unit, first, last, n: values.length, direction };
  const range = { least: valueText(name, Math.min(...values)), most: valueText(name, Math.max(...values)) };
  return {
    name,
    title,
    unit,
    about: t(`progress.${name}.about`),
    direction,
    dots: known.map(([k, value]) => ({
      x: whole.length === 1 ? WIDTH / 2 : MARGIN + k * across,
      y: HEIGHT - MARGIN - ((HEIGHT - 2 * MARGIN) * value) / top,
      compared: progress.sessions[k]?.mode === mode,
    })),
    joined: progress.directions[name] !== "few",
    top: valueText(name, top),
    latest: t("progress.latest", { value: last }),
    words: values.length > 1 ? t("progress.plot", { ...said, ...range }) : t("progress.plotOne", said),
  };
}

function directionText(progress: RiderProgress, name: Quantity, n: number): string {
  const direction = progress.directions[name];
  return t(`progress.${direction}`, { n, least: progress.min_sessions });
}
