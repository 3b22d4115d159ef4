// Reasons come and go twenty times a second; people read and hear slower.

import type { Why } from "./messages";

/** A sentence stays to be read at least this long, ms (assumed). */
const READ = 1_500;
/** It is spoken once it has lasted this long, ms (assumed). */
const LASTS = 700;
/** The same is not spoken again before this is over, ms (assumed). */
const AGAIN = 15_000;

/** What is shown and what was last spoken. */
export interface Saying {
  readonly shown: Why | null;
  readonly since: number;
  readonly spoken: string;
  readonly spokenAt: number;
}

export const SILENT: Saying = { shown: null, since: -Infinity, spoken: "", spokenAt: -Infinity };

/** A reason, or none, is the newest now. */
export function told(was: Saying, why: Why | null, now: number): Saying {
  const same = was.shown?.code === why?.code;
  const held = was.shown !== null && now - was.since < READ;
  const saying = same || held ? was : { ...was, shown: why, since: now };
  return spoken(saying, why, now);
}

function spoken(saying: Saying, why: Why | null, now: number): Saying {
  const { shown, since } = saying;
  if (!shown || shown.code !== why?.code || now - since < LASTS) return saying;
  if (shown.text === saying.spoken && now - saying.spokenAt < AGAIN) {
    return saying;
  }
  return { ...saying, spoken: shown.text, spokenAt: now };
}
