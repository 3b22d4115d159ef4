// What a detour costs, on the map where it is farthest from the route without it.

import type { RouteUpdate, WishPreview } from "../messages";
import { detour } from "../words";
import { badge, badgeWidth, HEIGHT } from "./badge";
import { covers, type Disc } from "./labels";
import type { Colours } from "./palette";
import { farthestFrom } from "./strokes";
import { toScreen, type Point, type View } from "./view";

type Ways = Pick<RouteUpdate, "points" | "without_wishes" | "extra_length">;
type Preview = Pick<WishPreview, "points" | "extra_length">;

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

/** The detour of the wishes that hold, or of one that is looked at; null: there is none. */
export function detourOf(route: Ways, preview: Preview | null): Detour | null {
  const [of, from, extra] = preview
    ? [preview.points, route.points, preview.extra_length]
    : [route.points, route.without_wishes, route.extra_length];
  if (Math.abs(extra) < 0.05) return null;
  const at = farthestFrom(of, from);
  return at && { at, text: detour(extra) };
}

/** True if a badge may lie at a point: whole, and under nothing. */
export function fits(wide: number, [x, y]: Point, screen: Area, clear: readonly Disc[]): boolean {
  const [dx, dy] = [wide / 2, HEIGHT / 2];
  if (x - dx < screen.left || x + dx > screen.right || y - dy < screen.top || y + dy > screen.bottom) return false;
  return !clear.some((disc) => covers({ width: wide, height: HEIGHT }, x, y, disc));
}

/** Draws the badge of the detour in each frame, for the chair moves under it. */
export class DetourBadge {
  #of: readonly [Ways, Preview | null] | null = null;
  #found: Detour | null = null;

  /** Returns what it covers, for the names; null: nothing. */
  draw(
    context: CanvasRenderingContext2D,
    { route, preview, colours }: { readonly route: Ways; readonly preview: Preview | null; readonly colours: Colours },
    view: View,
    screen: Area,
    clear: readonly Disc[],
  ): Disc | null {
    if (this.#of?.[0] !== route || this.#of[1] !== preview) {
      this.#of = [route, preview];
      this.#found = detourOf(route, preview);
    }
    if (!this.#found) return null;
    const at = toScreen(view, ...this.#found.at);
    const wide = badgeWidth(context, this.#found.text);
    if (!fits(wide, at, screen, clear)) return null;
    badge(context, this.#found.text, at[0], at[1], preview ? colours.preview : colours.route, colours.free);
    return { x: at[0], y: at[1], radius: wide / 2 };
  }
}
