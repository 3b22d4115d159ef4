// Heights and outlines of what stands on the floor, as the server tells them.

import { ask } from "../server";

export interface SolidShape {
  /** Corners, m. */
  readonly outline: readonly (readonly [number, number])[];
  readonly height: number;
  /** False: an obstacle of the simulated world that the map does not have. */
  readonly on_map: boolean;
  /** True if no sensor sees it. */
  readonly glass: boolean;
}

export interface FloorSolids {
  readonly wall_height: number;
  readonly ceiling: boolean;
  readonly solids: readonly SolidShape[];
  /** Outlines of floor that the rider avoids, m. */
  readonly wet: readonly (readonly (readonly [number, number])[])[];
}

/** Walls of an assumed height and nothing else, where the server tells nothing. */
export const WALLS_ONLY: FloorSolids = { wall_height: 2.5, ceiling: true, solids: [], wet: [] };

export async function loadSolids(): Promise<FloorSolids> {
  const answer = await ask<FloorSolids>("GET", "/api/floor/solids");
  return answer.ok ? answer.value : WALLS_ONLY;
}
