// What is about the chair: free directions, what blocks them, and the cause of a stop on the map.

import type { ChairState, PersonInfo, PlaceInfo, SceneInfo } from "./messages";
import { areaOf, contains, distance, distanceToLine, distanceToSegment, lastOf, lengthTo } from "./map/strokes";
import type { Point } from "./map/view";

export type Thing = "person" | "door" | "wall" | "object";
export type Freedom = "free" | "narrow" | "blocked" | "unseen";

/** One direction of the ring, counter-clockwise from ahead. */
export interface Direction {
  readonly angle: number;
  readonly freedom: Freedom;
  /** What is there; null where it is free or not seen. */
  readonly by: Thing | null;
}

/** What a stop or a slow-down is due to, and where it is. */
export interface Cause {
  readonly thing: Thing | "edge";
  readonly at: Point;
  /** Of a person: what they do. */
  readonly moves?: "crossing" | "coming" | "standing";
  /** Of a door: the place that is nearest. */
  readonly name?: string;
}

/** True where the map has a wall near a point. */
export type IsWall = (x: number, y: number) => boolean;

/** Nearer than this a direction is blocked, or narrow, m (assumed). */
const BLOCKED = 0.35;
const NARROW = 0.9;
/** A measured distance may differ so much from a person's or door's own, m. */
const MATCH = 0.7;
/** A cause lies no farther than this from the chair, m. */
const NEAR = 4;
/** A door that shuts off a place lies no farther from it than this, m (assumed). */
const FAR = 8;
const AHEAD = (75 * Math.PI) / 180;
const WALKS = 0.25;
/** A route leads through a door if it comes so near to its middle, m (assumed). */
const ON_ROUTE = 0.8;

export type About = Pick<ChairState, "pose" | "people" | "free" | "closed_doors">;

export function ring(state: About, scene: Pick<SceneInfo, "doors">, isWall: IsWall): Direction[] {
  const free = state.free ?? [];
  return free.map((d, k): Direction => {
    const angle = (2 * Math.PI * k) / free.length;
    if (d < 0) return { angle, freedom: "unseen", by: null };
    if (d >= NARROW) return { angle, freedom: "free", by: null };
    const freedom = d < BLOCKED ? "blocked" : "narrow";
    return { angle, freedom, by: thingAt(state, scene, isWall, angle, d) };
  });
}

/** Half the length of a chair, m: `free` counts from its outline (assumed). */
const BODY = 0.5;

/** Point of the map in a direction, so far from the chair's outline. */
export function pointAt(pose: ChairState["pose"], angle: number, d: number): Point {
  const heading = pose[2] + angle;
  return [pose[0] + (d + BODY) * Math.cos(heading), pose[1] + (d + BODY) * Math.sin(heading)];
}

function thingAt(state: About, scene: Pick<SceneInfo, "doors">, isWall: IsWall, angle: number, d: number): Thing {
  const at = pointAt(state.pose, angle, d);
  if (state.people?.some((person) => distance([person.x, person.y], at) < MATCH)) return "person";
  if (closed(state, scene).some((door) => distanceToSegment(at, door.a, door.b) < MATCH)) return "door";
  return isWall(...at) ? "wall" : "object";
}

/** Cause of the present stop or slow-down, as far as it can be seen. */
export function causeOf(
  state: About & Pick<ChairState, "remaining">,
  scene: Pick<SceneInfo, "doors" | "places">,
  route: readonly Point[],
  isWall: IsWall,
): Cause | null {
  const here: Point = [state.pose[0], state.pose[1]];
  const ahead = state.remaining == null ? [] : lastOf(route, state.remaining);
  const door = closed(state, scene).find((each) => {
    const middle = middleOf(each);
    const onRoute = ahead.some((point) => distance(point, here) < NEAR && distance(point, middle) < ON_ROUTE);
    return onRoute || (distance(here, middle) < 2.5 && isAhead(state.pose, middle));
  });
  if (door) return { thing: "door", at: middleOf(door), name: nearestName(scene.places, middleOf(door)) };
  const person = nearestAhead(state);
  if (person) return { thing: "person", at: [person.x, person.y], moves: movesOf(person, state.pose) };
  return thingAhead(state, isWall);
}

function thingAhead(state: About, isWall: IsWall): Cause | null {
  const free = state.free ?? [];
  let best: { angle: number; d: number } | null = null;
  free.forEach((d, k) => {
    const angle = (2 * Math.PI * k) / free.length;
    const off = Math.abs(Math.atan2(Math.sin(angle), Math.cos(angle)));
    if (d >= 0 && d < NARROW && off <= AHEAD && (!best || d < best.d)) best = { angle, d };
  });
  if (!best) return null;
  const { angle, d } = best as { angle: number; d: number };
  const at = pointAt(state.pose, angle, d);
  return { thing: isWall(...at) ? "wall" : "object", at };
}

function nearestAhead({ pose, people }: About): PersonInfo | null {
  const there = (people ?? [])
    .map((person) => ({ person, d: distance([person.x, person.y], [pose[0], pose[1]]) }))
    .filter(({ person, d }) => d < NEAR && isAhead(pose, [person.x, person.y]))
    .sort((a, b) => a.d - b.d);
  return there[0]?.person ?? null;
}

function movesOf({ vx, vy }: PersonInfo, pose: ChairState["pose"]): "crossing" | "coming" | "standing" {
  if (Math.hypot(vx, vy) < WALKS) return "standing";
  const along = vx * Math.cos(pose[2]) + vy * Math.sin(pose[2]);
  return along < -0.7 * Math.hypot(vx, vy) ? "coming" : "crossing";
}

function isAhead(pose: ChairState["pose"], [x, y]: Point): boolean {
  const angle = Math.atan2(y - pose[1], x - pose[0]) - pose[2];
  return Math.abs(Math.atan2(Math.sin(angle), Math.cos(angle))) <= AHEAD;
}

type Door = SceneInfo["doors"][number];

function closed(state: Pick<About, "closed_doors">, scene: Pick<SceneInfo, "doors">): Door[] {
  return scene.doors.filter((door) => state.closed_doors?.includes(door.id));
}

export function middleOf(door: Pick<Door, "a" | "b">): Point {
  return [(door.a[0] + door.b[0]) / 2, (door.a[1] + door.b[1]) / 2];
}

/** A shut door on a line, as a route that was given up; null: there is none. */
export function doorOn(state: Pick<About, "closed_doors">, scene: Pick<SceneInfo, "doors" | "places">, line: readonly Point[]): Cause | null {
  const at = closed(state, scene).map(middleOf).find((door) => distanceToLine(door, line) < ON_ROUTE);
  return at ? { thing: "door", at, name: nearestName(scene.places, at) } : null;
}

/** The first shut door on what is left of a route, and the way to it, m; null: there is none. */
export function doorAhead(
  state: Pick<About, "closed_doors">,
  scene: Pick<SceneInfo, "doors" | "places">,
  route: readonly Point[],
  left: number,
): { cause: Cause; after: number } | null {
  const line = lastOf(route, left);
  const found = closed(state, scene).flatMap((door) => {
    const at = middleOf(door);
    if (distanceToLine(at, line) >= ON_ROUTE) return [];
    const after = lengthTo(line, at);
    return [{ cause: { thing: "door", at, name: nearestName(scene.places, at) } as const, after }];
  });
  return found.sort((a, b) => a.after - b.after)[0] ?? null;
}

/** The shut door that is nearest to a point, and not far from it: what may keep a route from there. */
export function doorBy(state: About, scene: Pick<SceneInfo, "doors" | "places">, point: Point): Cause | null {
  const [door] = closed(state, scene)
    .map(middleOf)
    .filter((at) => distance(at, point) < FAR)
    .sort((a, b) => distance(a, point) - distance(b, point));
  return door ? { thing: "door", at: door, name: nearestName(scene.places, door) } : null;
}

/** Name of the place that is nearest to a point. */
export function nearestName(places: SceneInfo["places"], at: Point): string {
  const near = [...places].sort((a, b) => distance([a.x, a.y], at) - distance([b.x, b.y], at))[0];
  return near?.name ?? "";
}

/** Name of the place that is nearest to a point; empty where none is near. */
export function nameBy(places: SceneInfo["places"], at: Point): string {
  return nearestName(places.filter(({ x, y }) => distance([x, y], at) < FAR), at);
}

/** Name of the smallest area about a point; empty where there is none. */
export function placeAround(places: readonly PlaceInfo[], at: Point): string {
  const around = places.filter(({ area }) => area.length > 2 && contains(area, at));
  return around.sort((a, b) => areaOf(a.area) - areaOf(b.area))[0]?.name ?? "";
}

/** Names of the four sides, for what is read out. */
export const SIDES = ["ahead", "left", "behind", "right"] as const;
export type Side = (typeof SIDES)[number];

/** The worst direction of each side: what is read out instead of a picture. */
export function sides(directions: readonly Direction[]): { side: Side; by: Thing }[] {
  const found = new Map<Side, Thing>();
  for (const { angle, freedom, by } of directions) {
    const side = SIDES[Math.round(angle / (Math.PI / 2)) % 4]!;
    if (freedom === "blocked" && by && !found.has(side)) found.set(side, by);
  }
  return SIDES.flatMap((side) => (found.has(side) ? [{ side, by: found.get(side)! }] : []));
}
