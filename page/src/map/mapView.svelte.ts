// State of the map view; the way of following is kept on this device.

import type { IsWall } from "../around";
import type { Point } from "./view";

/** `heading`: the chair's direction up; `chair`: north up; `route`: the whole route; `floor`: the whole floor; `free`: moved by hand. */
export type Follow = "heading" | "chair" | "route" | "floor" | "free";

const KEPT = "cohelm.map";

class MapViewState {
  follow = $state<Follow>(kept());
  /** The map shall show this point; taken by the map. */
  wanted = $state.raw<Point | null>(null);
  legend = $state(false);
  /** Height at the bottom of the map that a sheet covers, px. */
  covered = $state(0);
  /** Height above the sheet that a card covers, and at the top that messages cover, px. */
  card = $state(0);
  /** When a card went, or became smaller, ms: a touch meant for it must not reach the map below. */
  uncovered = -Infinity;
  messages = $state(0);
  /** Width of the map that its tools cover, px. */
  tools = $state(64);
  /** True if the map is too small for one column of its tools, as on a phone. */
  low = $state(false);
  /** All tools of a low map are shown. */
  more = $state(false);
  isWall = $state.raw<IsWall>(() => false);

  /** Follows the chair, and does so the next time, too. */
  keep(follow: "heading" | "chair"): void {
    this.follow = follow;
    try {
      localStorage.setItem(KEPT, follow);
    } catch {
      // A device that keeps nothing begins with the heading up.
    }
  }

  /** Back to the way of following that is kept. */
  back(): void {
    this.follow = kept();
  }

  /** True if the view fits the route or the floor by itself. */
  get fits(): boolean {
    return this.follow === "route" || this.follow === "floor";
  }

  show(point: Point): void {
    this.follow = "free";
    this.wanted = point;
  }
}

function kept(): Follow {
  try {
    return localStorage.getItem(KEPT) === "chair" ? "chair" : "heading";
  } catch {
    return "heading";
  }
}

export const mapView = new MapViewState();
