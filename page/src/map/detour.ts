// What a detour costs, on the map where it is farthest from the route without it.

import type { RouteUpdate } from "../messages";
import { detour } from "../words";
import { badge, badgeWidth, HEIGHT } from "./badge";
import { covers, type Disc } from "./labels";
import type { Colours } from "./palette";
import { farthestFrom } from "./strokes";
import { toScreen, type Point, type View } from "./view";

type Ways = Pick<RouteUpdate, "points" | "without_wishes" | "extra_length">;

/** A part of the screen, px. */
export interface Area {
  readonly left: number;
  readonly top: number;
  readonly right: number;
  readonly bottom: number;
}

export interface Detour {
  readonly at: Point;
  readonly text: string;
}

/** The detour of the wishes that hold; null: there is none. */
export function detourOf({ points, without_wishes, extra_length }: Ways): Detour | null {
  if (Math.abs(extra_length) < 0.05) return null;
  const at = farthestFrom(points, without_wishes);
  return at && { at, text: detour(extra_length) };
}

/** True if a badge may lie at a point: whole, and under nothing. */
export function fits(wide: number, [x, y]: Point, screen: Area, clear: readonly Disc[]): boolean {
  const [dx, dy] = [wide / 2, HEIGHT / 2];
  if (x - dx < screen.left || x + dx > screen.right || y - dy < screen.top || y + dy > screen.bottom) return false;
  return !clear.some((disc) => covers({ width: wide, height: HEIGHT }, x, y, disc));
}

/** Draws the badge of the detour in each frame, for the chair moves under it. */
export class DetourBadge {
  #of: Ways | null = null;
  #found: Detour | null = null;

  /** Returns what it covers, for the names; null: nothing. */
  draw(
    context: CanvasRenderingContext2D,
    { route, colours }: { readonly route: Ways; readonly colours: Colours },
    view: View,
    screen: Area,
    clear: readonly Disc[],
  ): Disc | null {
    if (this.#of !== route) {
      this.#of = route;
      this.#found = detourOf(route);
    }
    if (!this.#found) return null;
    const at = toScreen(view, ...this.#found.at);
    const wide = badgeWidth(context, this.#found.text);
    if (!fits(wide, at, screen, clear)) return null;
    badge(context, this.#found.text, at[0], at[1], colours.route, colours.free);
    return { x: at[0], y: at[1], radius: wide / 2 };
  }
}
