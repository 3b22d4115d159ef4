// Layer that changes seldom, drawn once: floor, doors, preferences, routes. Frames only copy it.

import type { MapDifference, RouteUpdate, SceneInfo, TripRoute } from "../messages";
import { drawDifferences } from "./differences";
import { badge } from "./badge";
import { drawEdges } from "./edges";
import type { Colours } from "./palette";
import { farthestFrom, lastOf, lengthOf } from "./strokes";
import { toScreen, type Box, type Point, type View } from "./view";

/** So much more than the screen is drawn on each side, as a share of it. */
const MARGIN = 0.2;
/** While the map turns: a copy does not serve for long. */
const TURNING_MARGIN = 0.03;

export interface Ground {
  readonly scene: SceneInfo;
  readonly floor: HTMLCanvasElement | null;
  readonly colours: Colours;
  readonly route: RouteUpdate;
  /** Remaining route length, to the metre; null: unknown. */
  readonly left: number | null;
  /** Routes of a trip that is looked at, and the chosen one; none: there is no overview. */
  readonly routes: readonly TripRoute[];
  readonly chosen: number;
  readonly shut: readonly number[];
  /** Where the building differs from the map, and the side of a cell, m. */
  readonly differences: readonly MapDifference[];
  readonly cell: number;
  /** Floor behind edges. */
  readonly edges: readonly Box[];
  /** True if doors carry their numbers. */
  readonly numbered: boolean;
}

interface Screen {
  readonly width: number;
  readonly height: number;
  readonly ratio: number;
  readonly turning: boolean;
}

export class Backdrop {
  #canvas = document.createElement("canvas");
  #view: View | null = null;
  #ground: Ground | null = null;
  #pad: Point = [0, 0];
  #size = "";

  /** Copies itself to the screen; draws itself anew where it does not serve any more. */
  show(to: CanvasRenderingContext2D, ground: Ground, view: View, width: number, height: number, ratio: number): void {
    const size = `${width} ${height} ${ratio}`;
    let shift = this.#size === size && same(this.#ground, ground) ? this.#shift(view) : null;
    if (!shift) {
      const turning = this.#view !== null && this.#view.turn !== view.turn;
      const margin = turning ? TURNING_MARGIN : MARGIN;
      this.#pad = [Math.ceil(margin * width), Math.ceil(margin * height)];
      this.#draw(ground, view, { width, height, ratio, turning });
      this.#size = size;
      shift = [0, 0];
    }
    to.setTransform(1, 0, 0, 1, 0, 0);
    const [x, y] = this.#pad;
    to.drawImage(
      this.#canvas,
      Math.round((shift[0] - x) * ratio),
      Math.round((shift[1] - y) * ratio),
    );
  }

  /** By how much the copy has to be moved, px; null: it does not reach so far. */
  #shift(view: View): Point | null {
    const was = this.#view;
    if (!was || was.scale !== view.scale || was.turn !== view.turn) return null;
    const [x, y] = toScreen(view, ...was.at);
    const dx = x - was.middle[0];
    const dy = y - was.middle[1];
    const near = Math.abs(dx) <= this.#pad[0] && Math.abs(dy) <= this.#pad[1];
    return near ? [dx, dy] : null;
  }

  #draw(ground: Ground, view: View, screen: Screen): void {
    const { width, height, ratio } = screen;
    this.#view = view;
    this.#ground = ground;
    const canvas = this.#canvas;
    const [px, py] = this.#pad;
    const wide = Math.ceil((width + 2 * px) * ratio);
    const high = Math.ceil((height + 2 * py) * ratio);
    if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
    const context = canvas.getContext("2d", { alpha: false })!;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = ground.colours.unknown;
    context.fillRect(0, 0, wide, high);
    context.setTransform(ratio, 0, 0, ratio, px * ratio, py * ratio);
    // Mipmaps make the floor crisp from afar, and cost too much to be made in every frame.
    context.imageSmoothingQuality = screen.turning ? "low" : "medium";
    drawFloor(context, ground, view);
    drawEdges(context, ground.edges, ground.colours, view);
    drawDifferences(context, ground.differences, ground.cell, ground.colours, view);
    drawDoors(context, ground, view);
    drawWishes(context, ground, view);
    if (ground.routes.length > 0) drawChoices(context, ground, view);
    else drawWays(context, ground, view);
  }
}

function same(a: Ground | null, b: Ground): boolean {
  return (
    a !== null &&
    a.scene === b.scene &&
    a.floor === b.floor &&
    a.colours === b.colours &&
    a.route === b.route &&
    a.left === b.left &&
    a.routes === b.routes &&
    a.chosen === b.chosen &&
    a.numbered === b.numbered &&
    a.differences === b.differences &&
    a.edges === b.edges &&
    a.shut.join() === b.shut.join()
  );
}

function drawFloor(context: CanvasRenderingContext2D, { scene, floor }: Ground, view: View): void {
  if (!floor) return;
  const { x, y, width, height, resolution } = scene.floor;
  const wide = width * resolution;
  const high = height * resolution;
  context.save();
  const [left, top] = toScreen(view, x, y + high);
  context.translate(left, top);
  context.rotate(-view.turn);
  context.drawImage(floor, 0, 0, wide * view.scale, high * view.scale);
  context.restore();
}

function drawDoors(context: CanvasRenderingContext2D, ground: Ground, view: View): void {
  const { colours, shut, numbered } = ground;
  for (const door of ground.scene.doors) {
    const closed = shut.includes(door.id);
    if (!closed && !numbered) continue;
    context.strokeStyle = closed ? colours.unwish : colours.door;
    context.lineWidth = closed ? 6 : 3;
    context.setLineDash(closed ? [] : [4, 4]);
    traced(context, [door.a, door.b], view);
    context.stroke();
    if (!numbered) continue;
    const [x, y] = toScreen(view, (door.a[0] + door.b[0]) / 2, (door.a[1] + door.b[1]) / 2);
    badge(context, `${door.id + 1}`, x, y, colours.door, colours.free);
  }
  context.setLineDash([]);
}

function drawWishes(context: CanvasRenderingContext2D, ground: Ground, view: View): void {
  const { colours } = ground;
  for (const wish of ground.route.wishes) {
    const avoided = wish.kind === "avoid";
    const colour = avoided ? colours.unwish : colours.wish;
    context.strokeStyle = colour;
    context.fillStyle = colour;
    context.lineWidth = 2;
    context.setLineDash(avoided ? [6, 4] : []);
    if (avoided && wish.points.length > 2) {
      traced(context, wish.points, view);
      context.closePath();
    } else if (avoided) {
      around(context, wish.points, wish.radius, view);
    } else if (wish.kind === "stroke") {
      context.lineWidth = 10;
      context.globalAlpha = 0.35;
      traced(context, wish.points, view);
    } else {
      context.beginPath();
    }
    if (avoided) {
      context.globalAlpha = 0.14;
      context.fill();
      context.globalAlpha = 1;
    }
    context.stroke();
    context.globalAlpha = 1;
    context.setLineDash([]);
    if (wish.kind === "attract") for (const point of wish.points) flag(context, point, colour, view);
  }
}

function drawWays(context: CanvasRenderingContext2D, ground: Ground, view: View): void {
  const { colours, route, left } = ground;
  const driven = left === null ? 0 : Math.max(0, lengthOf(route.points) - left);
  const ahead = lastOf(route.points, lengthOf(route.points) - driven);
  context.lineJoin = context.lineCap = "round";
  if (route.wishes.length > 0 && route.without_wishes.length > 1) {
    // Without wishes it is the way itself, and both begin where the chair was.
    const without = lastOf(route.without_wishes, lengthOf(route.without_wishes) - driven);
    dashed(context, without, colours.without, 3, [2, 8], view);
  }
  if (ahead.length > 1) {
    traced(context, ahead, view);
    context.strokeStyle = colours.free;
    context.lineWidth = 9;
    context.stroke();
    context.strokeStyle = colours.route;
    context.lineWidth = 5;
    context.stroke();
  }
  context.lineCap = "butt";
}

/** Routes to choose from: the chosen one last and strongest, each with its number. */
function drawChoices(context: CanvasRenderingContext2D, ground: Ground, view: View): void {
  const { colours, routes, chosen } = ground;
  const order = [...routes.keys()].sort((a, b) => Number(a === chosen) - Number(b === chosen));
  context.lineJoin = context.lineCap = "round";
  for (const k of order) {
    const { points } = routes[k]!;
    const own = k === chosen;
    traced(context, points, view);
    context.strokeStyle = colours.free;
    context.lineWidth = own ? 11 : 8;
    context.stroke();
    context.strokeStyle = own ? colours.route : colours.without;
    context.lineWidth = own ? 7 : 4;
    context.stroke();
  }
  context.lineCap = "butt";
  if (routes.length < 2) return;
  for (const k of order) {
    const others = routes.filter((_, n) => n !== k).flatMap((each) => each.points);
    const [x, y] = toScreen(view, ...(farthestFrom(routes[k]!.points, others) ?? routes[k]!.points[0]!));
    badge(context, `${k + 1}`, x, y, k === chosen ? colours.route : colours.without, colours.free);
  }
}

export function traced(context: CanvasRenderingContext2D, line: readonly Point[], view: View): void {
  context.beginPath();
  for (const point of line) context.lineTo(...toScreen(view, ...point));
}

function dashed(
  context: CanvasRenderingContext2D,
  line: readonly Point[],
  colour: string,
  width: number,
  dash: number[],
  view: View,
): void {
  traced(context, line, view);
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.stroke();
  context.setLineDash([]);
}

/** A band about one point or a line of two. */
function around(context: CanvasRenderingContext2D, points: readonly Point[], radius: number, view: View): void {
  const a = toScreen(view, ...points[0]!);
  const b = toScreen(view, ...points[points.length - 1]!);
  const r = Math.max(4, radius * view.scale);
  const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
  context.beginPath();
  context.arc(a[0], a[1], r, angle + Math.PI / 2, angle - Math.PI / 2);
  context.arc(b[0], b[1], r, angle - Math.PI / 2, angle + Math.PI / 2);
  context.closePath();
}

function flag(context: CanvasRenderingContext2D, point: Point, colour: string, view: View): void {
  const [x, y] = toScreen(view, ...point);
  context.fillStyle = colour;
  context.beginPath();
  context.arc(x, y - 18, 9, 0.8 * Math.PI, 0.2 * Math.PI);
  context.lineTo(x, y);
  context.closePath();
  context.fill();
}
