// What is drawn on the floor: route, plan, preferences, groups, wet floor, and the destination's pin.

import {
  CanvasTexture,
  Color,
  ConeGeometry,
  Float32BufferAttribute,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  RepeatWrapping,
  SRGBColorSpace,
  ShapeUtils,
  TorusGeometry,
  Vector2,
  type BufferGeometry,
} from "three";
import type { Colours } from "../map/palette";
import { lastOf, lengthOf } from "../map/strokes";
import { stripes } from "../map/edges";
import type { Box, Point } from "../map/view";
import type { ChairState, RouteUpdate } from "../messages";
import { areaOf } from "./contours";
import { geometryOf } from "./flat";
import { ball, coloured, joined, release, rod } from "./parts";
import { dashes, ribbon, type Strip } from "./ribbon";

/** Widths, m. */
const ROUTE = 0.11;
const CASING = 0.2;
const PLAN = 0.3;
const STROKE = 0.35;
/** Heights above the floor, m; what is drawn later lies above. */
const Z = { wet: 0.005, edge: 0.0055, group: 0.006, zone: 0.01, casing: 0.012, route: 0.016, plan: 0.02 } as const;
/** Side of a tile of stripes, px and m. */
const STRIPES = 64;
const STRIPE = 0.4;
/** Corners of a disc. */
const ROUND = 32;

export interface Ways {
  readonly route: Pick<RouteUpdate, "points" | "wishes" | "without_wishes">;
  /** Remaining length of the route, m; null: unknown. */
  readonly left: number | null;
}

export class Markings {
  readonly group = new Group();
  readonly #edges = new Group();
  readonly #ways = new Group();
  readonly #moving = new Group();
  readonly #goal: Group;

  constructor(
    readonly colours: Colours,
    wet: readonly (readonly Point[])[],
  ) {
    this.#goal = pin(colours);
    this.#goal.visible = false;
    this.group.add(this.#edges, this.#ways, this.#moving, this.#goal);
    for (const outline of wet) this.group.add(this.#flat(area(outline, Z.wet), colours.route, 0.25, 1));
  }

  /** Floor behind edges, with stripes; call it when they change. */
  edges(edges: readonly Box[]): void {
    release(this.#edges);
    const map = new CanvasTexture(stripes(this.colours, STRIPES));
    map.wrapS = map.wrapT = RepeatWrapping;
    map.colorSpace = SRGBColorSpace;
    const strip = tiles(edges, Z.edge);
    const made = new Mesh(geometryOf(strip), new MeshBasicMaterial({ map }));
    const uv = strip.positions.filter((_, k) => k % 3 < 2).map((metres) => metres / STRIPE);
    made.geometry.setAttribute("uv", new Float32BufferAttribute(uv, 2));
    made.visible = edges.length > 0;
    this.#edges.add(made);
  }

  /** Routes and preferences; call it when they change. */
  ways({ route, left }: Ways): void {
    const { colours } = this;
    release(this.#ways);
    const driven = left === null ? 0 : Math.max(0, lengthOf(route.points) - left);
    const ahead = (line: readonly Point[]): Point[] => lastOf(line, lengthOf(line) - driven);
    for (const wish of route.wishes) this.#wish(wish);
    if (route.wishes.length > 0 && route.without_wishes.length > 1) {
      this.#put(dashes(ahead(route.without_wishes), 0.07, Z.casing, 0.1, 0.25), colours.without, 0.9, 4);
    }
    const points = ahead(route.points);
    this.#put(ribbon(points, CASING, Z.casing), colours.free, 0.85, 4);
    this.#put(ribbon(points, ROUTE, Z.route), colours.route, 1, 5);
  }

  /** What changes with every state. */
  state({ plan, groups, goal }: Pick<ChairState, "plan" | "groups" | "goal">): void {
    const { colours } = this;
    release(this.#moving);
    for (const outline of groups) this.#moving.add(this.#flat(area(outline, Z.group), colours.group, 0.25, 1));
    const ahead = ribbon(plan.map(([x, y]): Point => [x, y]), PLAN, Z.plan);
    this.#moving.add(this.#flat(ahead, colours.plan, 0.5, 7));
    this.#goal.visible = goal !== null;
    if (goal) this.#goal.position.set(goal.x, goal.y, 0);
  }

  #wish({ kind, points, radius }: RouteUpdate["wishes"][number]): void {
    const { wish, unwish } = this.colours;
    if (kind === "avoid") {
      const outline = points.length > 2 ? points : around(points, radius);
      this.#put(area(outline, Z.zone), unwish, 0.18, 3);
      this.#put(dashes([...outline, outline[0]!], 0.05, Z.zone, 0.2, 0.12), unwish, 1, 3);
    } else if (kind === "stroke") {
      this.#put(ribbon(points, STROKE, Z.zone), wish, 0.35, 3);
    } else {
      for (const [x, y] of points) this.#ways.add(flag(x, y, wish));
    }
  }

  #put(strip: Strip, colour: string, opacity: number, order: number): void {
    this.#ways.add(this.#flat(strip, colour, opacity, order));
  }

  #flat(strip: Strip, colour: string, opacity: number, order: number): Mesh {
    const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthWrite: false });
    const made = new Mesh(geometryOf(strip), material);
    made.visible = strip.indices.length > 0;
    made.renderOrder = order;
    made.frustumCulled = false; // its bounds cost more than its few triangles
    return made;
  }
}

/** A polygon on the floor; it faces up. */
export function area(outline: readonly Point[], z: number): Strip {
  const points = areaOf(outline) < 0 ? [...outline].reverse() : outline;
  const triangles = ShapeUtils.triangulateShape(points.map(([x, y]) => new Vector2(x, y)), []);
  return { positions: points.flatMap(([x, y]) => [x, y, z]), indices: triangles.flat() };
}

/** Boxes on the floor; they face up. */
export function tiles(boxes: readonly Box[], z: number): Strip {
  const positions = boxes.flatMap(({ x, y, width, height }) => {
    const [right, top] = [x + width, y + height];
    return [x, y, z, right, y, z, right, top, z, x, top, z];
  });
  const indices = boxes.flatMap((_, k) => [0, 1, 2, 0, 2, 3].map((corner) => 4 * k + corner));
  return { positions, indices };
}

/** Outline of what is within a radius of a point, or of a line of two. */
export function around(points: readonly Point[], radius: number): Point[] {
  const a = points[0]!;
  const b = points[points.length - 1]!;
  const along = Math.atan2(b[1] - a[1], b[0] - a[0]);
  return Array.from({ length: ROUND }, (_, k): Point => {
    const [x, y] = k < ROUND / 2 ? b : a;
    const angle = along - Math.PI / 2 + (2 * Math.PI * k) / ROUND;
    return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
  });
}

/** Its tip is on the floor. */
function pin(colours: Colours): Group {
  const [colour, hole] = [new Color(colours.route), new Color(colours.free)];
  const cone = coloured(new ConeGeometry(0.15, 0.55, 20).rotateX(-Math.PI / 2).translate(0, 0, 0.29), colour);
  const ring = coloured(new TorusGeometry(0.34, 0.03, 8, 36).translate(0, 0, 0.03), colour);
  const made = new Group();
  made.add(solid(joined([cone, ball([0, 0, 0.68], 0.2, colour), ball([0, 0, 0.81], 0.1, hole), ring])));
  return made;
}

function flag(x: number, y: number, colour: string): Mesh {
  const tint = new Color(colour);
  const made = solid(joined([rod([0, 0, 0], [0, 0, 0.8], 0.02, tint, 8), ball([0, 0, 0.85], 0.12, tint)]));
  made.position.set(x, y, 0);
  return made;
}

function solid(geometry: BufferGeometry): Mesh {
  return new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true }));
}
