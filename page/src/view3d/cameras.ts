// Three places to look from, in the map's frame (REP-103: x forward, y left, z up).

export const CAMERAS = ["behind", "above", "eyes"] as const;
export type CameraName = (typeof CAMERAS)[number];

export type Vector = readonly [x: number, y: number, z: number];
export type Pose = readonly [x: number, y: number, heading: number];

/** A camera: where it is, what it looks at, which way is up on the screen, and its view. */
export interface Sight {
  readonly at: Vector;
  readonly look: Vector;
  readonly up: Vector;
  /** Vertical angle of view, degrees. */
  readonly angle: number;
  /** Walls are cut at this height, so that one sees over them, m; null: they are whole. */
  readonly cut: number | null;
}

/** Eyes of a seated rider above the floor (seat 0.53 m, sitting eye height 0.7 m; assumed), m. */
export const EYE_HEIGHT = 1.23;
const EYES_AHEAD = -0.02;
/** So low a wall hides nobody whom a camera above it looks at (assumed), m. */
const CUT = 1.15;
const UP: Vector = [0, 0, 1];
/** Time constant of a camera that follows, s (assumed). */
const LAG = 0.22;
export const NEAREST = 0.45;
export const FARTHEST = 3.2;

/** A camera about a pose; `zoom` above 1 is farther away. */
export function sightOf(camera: CameraName, [x, y, heading]: Pose, zoom = 1): Sight {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const ahead = (d: number, z: number): Vector => [x + d * c, y + d * s, z];
  switch (camera) {
    case "behind":
      return { at: ahead(-3.1 * zoom, 0.55 + 2 * zoom), look: ahead(1.5, 0.45), up: UP, angle: 50, cut: CUT };
    case "above":
      return { at: [x, y - 5.5 * zoom, 15 * zoom], look: [x, y + 0.4, 0], up: [0, 1, 0], angle: 40, cut: CUT };
    case "eyes":
      return { at: ahead(EYES_AHEAD, EYE_HEIGHT), look: ahead(2.5, EYE_HEIGHT - 0.55), up: UP, angle: 70, cut: null };
  }
}

/** `zoom` times a factor, within what is useful. */
export function zoomedBy(zoom: number, factor: number): number {
  return Math.min(FARTHEST, Math.max(NEAREST, zoom * factor));
}

/** Sight after `seconds` on its way to another; the rider's eyes have no lag. */
export function followed(was: Sight | null, to: Sight, seconds: number): Sight {
  if (!was || was.cut !== to.cut || was.up !== to.up || to.cut === null) return to;
  const share = 1 - Math.exp(-Math.max(0, seconds) / LAG);
  const mixed = (a: Vector, b: Vector): Vector => [
    a[0] + share * (b[0] - a[0]),
    a[1] + share * (b[1] - a[1]),
    a[2] + share * (b[2] - a[2]),
  ];
  return { ...to, at: mixed(was.at, to.at), look: mixed(was.look, to.look) };
}

/** Columns of the rotation from a headset's frame (x right, y up, z back) to the map's. */
export function headsetAxes(heading: number): readonly [right: Vector, up: Vector, back: Vector] {
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return [[s, -c, 0], UP, [-c, -s, 0]];
}
