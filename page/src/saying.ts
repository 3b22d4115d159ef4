// Reasons come and go twenty times a second; people read and hear slower.

import type { Why } from "./messages";

/** A sentence stays to be read at least this long, ms (assumed). */
const READ = 1_500;
/** It is spoken once it has lasted this long, ms (assumed). */
const LASTS = 700;
/** The same is not spoken again before this is over, ms (assumed). */
const AGAIN = 15_000;

/** What is shown, and what is spoken. */
export interface Saying {
  readonly shown: Why | null;
  readonly since: number;
  /** What the live region holds: empty again once nothing is shown. */
  readonly spoken: string;
  readonly last: string;
  readonly lastAt: number;
}

export const SILENT: Saying = { shown: null, since: -Infinity, spoken: "", last: "", lastAt: -Infinity };

/** A reason, or none, is the newest now. */
export function told(was: Saying, why: Why | null, now: number): Saying {
  const same = was.shown?.code === why?.code && was.shown?.text === why?.text;
  const held = was.shown !== null && now - was.since < READ;
  if (same) return spoken(was, now);
  return held ? was : { ...was, shown: why, since: now, spoken: "" };
}

function spoken(saying: Saying, now: number): Saying {
  const { shown, since, last, lastAt } = saying;
  if (!shown || saying.spoken === shown.text || now - since < LASTS) return saying;
  if (shown.text === last && now - lastAt < AGAIN) return saying;
  return { ...saying, spoken: shown.text, last: shown.text, lastAt: now };
}
