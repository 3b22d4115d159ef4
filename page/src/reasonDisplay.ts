// Reasons change twenty times a second; people read and listen more slowly.

import type { ReasonText } from "./messages";

/** A sentence stays to be read at least this long, ms (assumed). */
const READ = 1_500;
/** It is spoken once it has lasted this long, ms (assumed). */
const LASTS = 700;
/** Minimum time before the same sentence is spoken again, ms (assumed). */
const AGAIN = 15_000;

/** Reason on display, and the sentence for screen readers. */
export interface ReasonDisplay {
  readonly shown: ReasonText | null;
  readonly since: number;
  /** Content of the live region; empty when no reason is shown. */
  readonly spoken: string;
  readonly last: string;
  readonly lastAt: number;
}

export const SILENT: ReasonDisplay = { shown: null, since: -Infinity, spoken: "", last: "", lastAt: -Infinity };

/** A reason, or none, is the newest now. */
export function told(was: ReasonDisplay, why: ReasonText | null, now: number): ReasonDisplay {
  const same = was.shown?.code === why?.code && was.shown?.text === why?.text;
  const held = was.shown !== null && now - was.since < READ;
  if (same) return spoken(was, now);
  return held ? was : { ...was, shown: why, since: now, spoken: "" };
}

function spoken(saying: ReasonDisplay, now: number): ReasonDisplay {
  const { shown, since, last, lastAt } = saying;
  if (!shown || saying.spoken === shown.text || now - since < LASTS) return saying;
  if (shown.text === last && now - lastAt < AGAIN) return saying;
  return { ...saying, spoken: shown.text, last: shown.text, lastAt: now };
}
