import { CENTRE, deflection, type Deflection } from "./deflection";

/** A finger, pen or mouse on the joystick: where it came down and where it is, px. */
export interface Grip {
  readonly pointer: number;
  readonly from: readonly [number, number];
  readonly to: readonly [number, number];
}

/** The first pointer holds the stick, and where it comes down is the centre: a touch alone never
 * moves the chair. Further fingers are free for other things, such as STOP. */
export function gripped(grip: Grip | null, pointer: number, x: number, y: number): Grip {
  return grip ?? { pointer, from: [x, y], to: [x, y] };
}

export function dragged(grip: Grip | null, pointer: number, x: number, y: number): Grip | null {
  return grip?.pointer === pointer ? { ...grip, to: [x, y] } : grip;
}

/** Lifted, cancelled or captured by somebody else: the stick springs back. */
export function lifted(grip: Grip | null, pointer: number): Grip | null {
  return grip?.pointer === pointer ? null : grip;
}

/** Full deflection is `reach` px from where the finger came down; the screen's y points down. */
export function pull(grip: Grip | null, reach: number): Deflection {
  if (!grip || !(reach > 0)) return CENTRE;
  const right = grip.to[0] - grip.from[0];
  const down = grip.to[1] - grip.from[1];
  return deflection(-down / reach, -right / reach);
}
