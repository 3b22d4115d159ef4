// Names on the map that do not lie on each other, nor on the chair.

export interface Label {
  readonly name: string;
  /** Its point on the screen, px. */
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** A label's middle, and where it lies from its point. */
export interface Placed {
  readonly label: Label;
  readonly x: number;
  readonly y: number;
  readonly aside: number;
}

/** On its point, or above, below, right or left of it, in widths and heights of the label. */
const ASIDE: readonly (readonly [number, number])[] = [
  [0, 0], [0, -0.8], [0, 0.8], [0.6, 0], [-0.6, 0], [0, -1.6], [0, 1.6],
  [0.6, -1.2], [-0.6, -1.2], [0.6, 1.2], [-0.6, 1.2],
];
/** Cost of each place further down that list, and of any but the one before: on a map that turns, names do not jump. */
const FURTHER = 0.01;
const ELSEWHERE = 0.1;
/** Room between two names, px: half of it above one another, twice that side by side, where they would read as one. */
const AIR = 4;

/** The labels that find room, those that come first before the others; each where it lies on the fewest walls.
 * walled: the part of a label that lies on walls, 0…1. */
export function placed(
  labels: readonly Label[], before: readonly Placed[] = [], walled: (one: Placed) => number = () => 0,
): Placed[] {
  const was = new Map(before.map((each) => [each.label.name, each.aside]));
  // Those that were shown come first, so that none comes and goes with every step of a turn.
  const order = [...labels].sort((a, b) => Number(was.has(b.name)) - Number(was.has(a.name)));
  const done: Placed[] = [];
  for (const label of order) {
    const first = was.get(label.name) ?? 0;
    let best: Placed | null = null;
    let least = Infinity;
    for (const aside of ASIDE.keys()) {
      const one = at(label, aside);
      const fixed = FURTHER * aside + (aside === first ? 0 : ELSEWHERE);
      if (fixed >= least || done.some((other) => overlap(one, other))) continue;
      const cost = fixed + walled(one);
      if (cost < least) [best, least] = [one, cost];
    }
    if (best) done.push(best);
  }
  return done;
}

function at(label: Label, aside: number): Placed {
  const [across, down] = ASIDE[aside]!;
  return { label, x: label.x + across * label.width, y: label.y + down * label.height, aside };
}

export function overlap(a: Placed, b: Placed): boolean {
  return (
    2 * Math.abs(a.x - b.x) < a.label.width + b.label.width + 4 * AIR &&
    2 * Math.abs(a.y - b.y) < a.label.height + b.label.height + AIR
  );
}

/** A round area on the screen that names keep clear of. */
export interface Disc {
  readonly x: number;
  readonly y: number;
  readonly radius: number;
}

export function covers(label: Pick<Label, "width" | "height">, x: number, y: number, { x: cx, y: cy, radius }: Disc): boolean {
  const dx = Math.max(0, Math.abs(x - cx) - label.width / 2);
  const dy = Math.max(0, Math.abs(y - cy) - label.height / 2);
  return Math.hypot(dx, dy) < radius;
}

/** Width of a tool of the map with its gap, px. */
const TOOL = 50;

/** Where the row of tools of a low map lies. bottom: of what no card or sheet covers, px. */
export function underTools(width: number, bottom: number): Disc[] {
  return [0, 1, 2].map((k) => ({ x: width - (k + 0.55) * TOOL, y: bottom - TOOL / 2, radius: TOOL / 2 }));
}
