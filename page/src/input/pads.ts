import { deflection, type Deflection } from "./deflection";

/** Fields of the web platform's `Gamepad` that are read. */
export interface Pad {
  readonly index: number;
  readonly connected: boolean;
  readonly mapping: string;
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean }[];
}

/** Command buttons of a gamepad that are pressed. */
export interface PadButtons {
  readonly stop: boolean;
  readonly resume: boolean;
}

/** Standard mapping: https://www.w3.org/TR/gamepad/#remapping */
const FACE = [0, 1, 2, 3];
const START = 9;
const [UP, DOWN, LEFT, RIGHT] = [12, 13, 14, 15] as const;
/** Deflection of the D-pad (assumed). */
const CROSS = 0.6;

/** Left stick, or the cross where the stick rests. Its axes point right and down. */
export function padDeflection(pad: Pad): Deflection {
  const stick = deflection(-(pad.axes[1] ?? 0), -(pad.axes[0] ?? 0));
  if (pad.mapping !== "standard") return stick;
  const forward = down(pad, UP) - down(pad, DOWN);
  const left = down(pad, LEFT) - down(pad, RIGHT);
  if (forward === 0 && left === 0) return stick;
  return deflection(forward * CROSS, left * CROSS);
}

/** Any of the four large buttons is STOP and Start is “Go on”; on a device whose buttons are not
 * known, every one is STOP. */
export function padButtons(pad: Pad): PadButtons {
  if (pad.mapping !== "standard") {
    return { stop: pad.buttons.some((button) => button.pressed), resume: false };
  }
  return { stop: FACE.some((n) => down(pad, n) === 1), resume: down(pad, START) === 1 };
}

/** Newly pressed commands. A button held while the gamepad connects stops the chair, but it never
 * goes on. */
export function newlyPressed(pad: Pad, was: PadButtons | undefined): PadButtons {
  const now = padButtons(pad);
  const before = was ?? { stop: false, resume: true };
  return { stop: now.stop && !before.stop, resume: now.resume && !before.resume };
}

/** The gamepads that are there; none where the browser does not say. */
export function connectedPads(source: Pick<Navigator, "getGamepads">): Pad[] {
  try {
    return [...source.getGamepads()].filter((pad): pad is Gamepad => pad !== null && pad.connected);
  } catch {
    return []; // forbidden by policy, or not there at all
  }
}

function down(pad: Pad, button: number): 0 | 1 {
  return pad.buttons[button]?.pressed ? 1 : 0;
}
