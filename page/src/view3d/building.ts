// Walls, furniture, glass and doors of a floor, extruded from its map and its solids.

import {
  BufferGeometry,
  Color,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  Mesh,
  MeshBasicMaterial,
} from "three";
import type { Colours } from "../map/palette";
import type { Point } from "../map/view";
import type { DoorInfo, FloorInfo, SceneInfo } from "../messages";
import { areaOf, maskOf, regionsOf, without, type Region } from "./contours";
import type { FloorSolids, SolidShape } from "./floorSolids";
import { Batch, painted, type Paint } from "./solids";

/** Thickness of a door's leaf and of the wall above a door (assumed), m. */
const LEAF = 0.07;
const LINTEL = 0.16;
/** Clear height of a door (assumed), m. */
const DOOR_HEIGHT = 2.1;
/** A piece of furniture ends in a slab that its body stands a little back from (assumed), m. */
const SLAB = 0.045;
const BACK = 0.035;

export interface Building {
  readonly group: Group;
  /** Shows walls up to a height; null: whole, with the ceiling. */
  cut(height: number | null): void;
  /** Shows the doors that are closed. */
  shut(doors: readonly number[]): void;
}

export interface Plan {
  readonly scene: Pick<SceneInfo, "floor" | "doors">;
  readonly solids: FloorSolids;
  readonly pixels: ImageData;
  readonly colours: Colours;
}

export function building(plan: Plan): Building {
  const { scene, solids, colours } = plan;
  const whole = solids.wall_height;
  const walls = mesh(wallBatch(wallsOf(plan), colours));
  const lintels = mesh(lintelBatch(scene.doors, whole, colours));
  const ceiling = solids.ceiling ? ceilingOf(scene.floor, whole, colours) : new Group();
  const leaves = new Group();
  const group = new Group();
  group.add(walls, lintels, ceiling, leaves, mesh(furnitureBatch(solids.solids, colours)), glassOf(solids.solids, colours));
  let height = whole;
  return {
    group,
    cut(to) {
      height = to === null ? whole : Math.min(to, whole);
      walls.scale.z = height;
      leaves.scale.z = Math.min(height, DOOR_HEIGHT);
      lintels.visible = ceiling.visible = to === null;
    },
    shut(ids) {
      for (const leaf of leaves.children) if (leaf instanceof Mesh) leaf.geometry.dispose();
      leaves.clear();
      const closed = scene.doors.filter((door) => ids.includes(door.id));
      if (closed.length > 0) leaves.add(mesh(leafBatch(closed, colours)));
    },
  };
}

/** Outlines of what is as high as the walls, m. */
export function wallsOf({ scene: { floor }, solids, pixels }: Omit<Plan, "colours">): Region[] {
  const { x, y, resolution } = floor;
  const cell = ([px, py]: Point): Point => [(px - x) / resolution, (py - y) / resolution];
  const metre = ([k, row]: Point): Point => [x + k * resolution, y + row * resolution];
  const furniture = solids.solids.filter((solid) => solid.on_map).map((solid) => solid.outline.map(cell));
  const mask = without(maskOf(pixels.data, pixels.width, pixels.height), furniture);
  return regionsOf(mask).map(({ outer, holes }) => ({
    outer: outer.map(metre),
    holes: holes.map((hole) => hole.map(metre)),
  }));
}

/** Walls of height 1: the mesh is as high as the camera lets it be. */
export function wallBatch(walls: readonly Region[], colours: Colours): Batch {
  const batch = new Batch(colours);
  const wall = new Color(colours.wall);
  const light = wall.clone().lerp(new Color(colours.free), 0.68);
  const paint: Paint = { top: wall, side: light, foot: light.clone().multiplyScalar(0.8) };
  for (const region of walls) batch.prism(region, 0, 1, paint);
  return batch;
}

export function furnitureBatch(solids: readonly SolidShape[], colours: Colours): Batch {
  const batch = new Batch(colours);
  const wood = new Color(colours.wall).lerp(new Color(colours.door), 0.45).lerp(new Color(colours.free), 0.5);
  const paint = painted(wood, 0.86, 0.62);
  for (const { outline, height, glass } of solids) {
    if (glass) continue;
    const body = height > 3 * SLAB ? height - SLAB : 0;
    if (body > 0) batch.prism({ outer: smaller(outline, BACK), holes: [] }, 0, body, paint);
    batch.prism({ outer: outline, holes: [] }, body, height, { ...paint, foot: paint.side });
  }
  return batch;
}

/** Every corner moved inwards by `by` m along both of its edges; thin outlines stay. */
export function smaller(outline: readonly Point[], by: number): readonly Point[] {
  const turn = Math.sign(areaOf(outline));
  const moved = outline.map((point, k): Point => {
    const before = outline[(k + outline.length - 1) % outline.length]!;
    const after = outline[(k + 1) % outline.length]!;
    const [a, b] = [inward(before, point, turn), inward(point, after, turn)];
    const share = by / Math.max(0.3, 1 + a[0] * b[0] + a[1] * b[1]);
    return [point[0] + share * (a[0] + b[0]), point[1] + share * (a[1] + b[1])];
  });
  return areaOf(moved) * turn > 0.4 * Math.abs(areaOf(outline)) ? moved : outline;
}

function inward(a: Point, b: Point, turn: number): Point {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
  return [(-turn * (b[1] - a[1])) / length, (turn * (b[0] - a[0])) / length];
}

function glassOf(solids: readonly SolidShape[], colours: Colours): Mesh {
  const batch = new Batch(colours);
  const tint = new Color(colours.route).lerp(new Color(colours.free), 0.5);
  for (const { outline, height, glass } of solids) {
    if (glass) batch.prism({ outer: outline, holes: [] }, 0, height, painted(tint, 1, 1));
  }
  const material = new MeshBasicMaterial({
    vertexColors: true,
    transparent: true,
    opacity: 0.32,
    depthWrite: false,
    side: DoubleSide,
  });
  const panes = new Mesh(batch.geometry(), material);
  panes.visible = batch.triangles > 0;
  panes.renderOrder = 4;
  return panes;
}

/** Wall above the doors, seen from within only. */
function lintelBatch(doors: readonly DoorInfo[], whole: number, colours: Colours): Batch {
  const batch = new Batch(colours);
  const light = new Color(colours.wall).lerp(new Color(colours.free), 0.5);
  if (whole <= DOOR_HEIGHT) return batch;
  for (const { a, b } of doors) batch.prism(bar(a, b, LINTEL), DOOR_HEIGHT, whole, painted(light, 0.95, 0.8));
  return batch;
}

function leafBatch(doors: readonly DoorInfo[], colours: Colours): Batch {
  const batch = new Batch(colours);
  const paint = painted(new Color(colours.unwish));
  for (const { a, b } of doors) batch.prism(bar(a, b, LEAF), 0, 1, paint);
  return batch;
}

/** Rectangle about the line from a to b. */
export function bar(a: Point, b: Point, thick: number): Region {
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
  const [nx, ny] = [(-thick * (b[1] - a[1])) / (2 * length), (thick * (b[0] - a[0])) / (2 * length)];
  const outer: Point[] = [
    [a[0] - nx, a[1] - ny],
    [b[0] - nx, b[1] - ny],
    [b[0] + nx, b[1] + ny],
    [a[0] + nx, a[1] + ny],
  ];
  return { outer, holes: [] };
}

/** Seen from below. */
function ceilingOf({ x, y, width, height, resolution }: FloorInfo, z: number, colours: Colours): Mesh {
  const [right, top] = [x + width * resolution, y + height * resolution];
  const made = new BufferGeometry();
  const corners = [x, y, z, x, top, z, right, top, z, right, y, z];
  made.setAttribute("position", new Float32BufferAttribute(corners, 3));
  made.setIndex([0, 1, 2, 0, 2, 3]);
  const colour = new Color(colours.free).lerp(new Color(colours.unknown), 0.5);
  return new Mesh(made, new MeshBasicMaterial({ color: colour }));
}

function mesh(batch: Batch): Mesh {
  const made = new Mesh(batch.geometry(), new MeshBasicMaterial({ vertexColors: true }));
  made.visible = batch.triangles > 0;
  return made;
}
