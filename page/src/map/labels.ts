// Names on the map that do not lie on each other.

export interface Label {
  readonly name: string;
  /** Its point on the screen, px. */
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A label's middle. */
export interface Placed {
  readonly label: Label;
  readonly x: number;
  readonly y: number;
}

/** On its point, or a little above, below, right or left of it: the first that is free. */
const ASIDE: readonly (readonly [number, number])[] = [
  [0, 0],
  [0, -0.8],
  [0, 0.8],
  [0.6, 0],
  [-0.6, 0],
];
const AIR = 4;

/** The labels that find room, those that come first before the others. */
export function placed(labels: readonly Label[]): Placed[] {
  const done: Placed[] = [];
  for (const label of labels) {
    for (const [across, down] of ASIDE) {
      const one = { label, x: label.x + across * label.width, y: label.y + down * label.height };
      if (done.some((other) => overlap(one, other))) continue;
      done.push(one);
      break;
    }
  }
  return done;
}

export function overlap(a: Placed, b: Placed): boolean {
  return (
    2 * Math.abs(a.x - b.x) < a.label.width + b.label.width + 2 * AIR &&
    2 * Math.abs(a.y - b.y) < a.label.height + b.label.height + AIR
  );
}
