// Rides that have ended since the view was opened: what is shown of them is read again.

import { chair } from "../chair.svelte";

/** A ride is measured before it is stored: after these times it is looked for, ms (assumed). */
const LOOKS = [2_000, 10_000];

class Stored {
  /** Grows when another ride may have been stored. */
  count = $state(0);

  /** Looks for a ride that has just ended; the result ends the looking. */
  follow(): (() => void) | undefined {
    if (!chair.ended) return undefined;
    const timers = LOOKS.map((after) => setTimeout(() => (this.count += 1), after));
    return () => timers.forEach(clearTimeout);
  }
}

export const stored = new Stored();
