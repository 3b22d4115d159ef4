// Which device steers now, and how: what the next beat says.

import type { Beat } from "../messages";

export type Device = NonNullable<Beat["device"]>;

export interface Deflection {
  /** −1…1, forward positive. */
  forward: number;
  /** −1…1, left positive. */
  left: number;
  device: Device;
}

export const CENTRED: Deflection = { forward: 0, left: 0, device: "none" };

/** What the heartbeat sends. */
export function deflection(): Deflection {
  return CENTRED;
}
