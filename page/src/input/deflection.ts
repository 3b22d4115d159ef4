/** Deflection of a stick, −1…1, forward and left (REP-103). */
export interface Deflection {
  readonly forward: number;
  readonly left: number;
}

export const CENTRE: Deflection = { forward: 0, left: 0 };

/** A deflection within the unit circle, whatever the device said; what is no number is 0. */
export function deflection(forward: number, left: number): Deflection {
  const f = Number.isFinite(forward) ? forward : 0;
  const l = Number.isFinite(left) ? left : 0;
  const scale = 1 / Math.max(1, Math.hypot(f, l));
  return { forward: bounded(f * scale), left: bounded(l * scale) };
}

export function size(d: Deflection): number {
  return Math.hypot(d.forward, d.left);
}

/** True if the stick is within the dead zone, edge included: it counts as released. */
export function isCentred(d: Deflection, deadZone: number): boolean {
  return size(d) <= deadZone;
}

function bounded(x: number): number {
  return Math.min(1, Math.max(-1, x)) + 0; // no −0 on the wire
}
