// State of the map view, stored on this device.

import type { Point } from "./view";

export type Follow = "chair" | "heading" | "free";

class MapViewState {
  follow = $state<Follow>("chair");
  /** The map shall show this point; taken by the map. */
  wanted = $state.raw<Point | null>(null);

  show(point: Point): void {
    this.follow = "free";
    this.wanted = point;
  }
}

export const mapView = new MapViewState();
