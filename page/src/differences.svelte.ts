// Places where the building differs from the map, and the one on the way ahead that the rider is told about, once.

import { chair } from "./chair.svelte";
import { distance, distanceToLine, distanceToSegment, lastOf } from "./map/strokes";
import type { Point } from "./map/view";
import type { ChairState, MapDifference, MapDifferences, SceneInfo } from "./messages";

/** What is new within this of the way ahead affects it, m (assumed): half a chair and the room beside it. */
const ON_ROUTE = 1;
/** Two reports within this are of the same place, m: it grows while more of it is seen (assumed). */
const SAME = 1.5;
/** A contradiction so near to a shut door is the door, m. */
const DOOR = 0.8;
const MOST = 60;
const KEPT = "cohelm.differences";

type Told = Pick<MapDifference, "kind" | "x" | "y">;

/** Those that are no shut door: doors are told as doors. */
export function withoutDoors(
  found: readonly MapDifference[],
  doors: SceneInfo["doors"],
  shut: readonly number[],
): MapDifference[] {
  const lines = doors.filter((door) => shut.includes(door.id));
  return found.filter(({ x, y }) => !lines.some((door) => distanceToSegment([x, y], door.a, door.b) < DOOR));
}

/** What is new on the way ahead: nothing else that the map lacks, and no wall that is gone, affects the rider. */
export function onTheWay(found: readonly MapDifference[], ahead: readonly Point[]): MapDifference[] {
  return found.filter(({ kind, cells }) => kind === "new" && cells.some((cell) => distanceToLine(cell, ahead) < ON_ROUTE));
}

/** The one of these that is nearest to the chair and has not been told; null: there is none. */
export function untold(
  found: readonly MapDifference[],
  told: readonly Told[],
  pose: ChairState["pose"],
): MapDifference | null {
  const from = ({ x, y }: MapDifference): number => distance([pose[0], pose[1]], [x, y]);
  const fresh = found.filter((each) => !told.some((other) => same(each, other)));
  return fresh.sort((a, b) => from(a) - from(b))[0] ?? null;
}

function same(a: Told, b: Told): boolean {
  return a.kind === b.kind && distance([a.x, a.y], [b.x, b.y]) < SAME;
}

class Differences {
  /** All that the map shows. */
  shown = $state.raw<readonly MapDifference[]>([]);
  /** The one that the rider is told about; it stays until it is closed or out of reach. */
  told = $state.raw<MapDifference | null>(null);
  #closed: readonly Told[] = stored();
  #of: MapDifferences | null = null;
  #shut = "";
  #affecting: readonly MapDifference[] = [];
  #way = "";

  /** Called ten times a second. */
  look(): void {
    const { state, scene, differences } = chair;
    const shut = state?.closed_doors ?? [];
    if (scene && differences && (differences !== this.#of || shut.join() !== this.#shut)) {
      [this.#of, this.#shut] = [differences, shut.join()];
      this.shown = withoutDoors(differences.found, scene.doors, shut);
      this.#way = "";
    }
    if (!state || state.remaining == null || this.shown.length === 0) {
      this.told = null;
      return;
    }
    const left = Math.round(state.remaining);
    const way = `${chair.route.version} ${left}`;
    if (way !== this.#way) {
      this.#way = way;
      this.#affecting = onTheWay(this.shown, lastOf(chair.route.points, left));
    }
    const { told } = this;
    const kept = told && untold(this.#affecting.filter((each) => same(each, told)), [], state.pose);
    this.told = kept ?? untold(this.#affecting, this.#closed, state.pose);
  }

  /** The rider has read it: it is told once on this device. */
  close(of: MapDifference): void {
    this.#closed = [...this.#closed, { kind: of.kind, x: of.x, y: of.y }].slice(-MOST);
    this.told = null;
    try {
      localStorage.setItem(KEPT, JSON.stringify(this.#closed));
    } catch {
      // A device that keeps nothing tells it again the next time.
    }
  }
}

function stored(): readonly Told[] {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(KEPT) ?? "[]");
    return Array.isArray(kept) ? (kept as Told[]) : [];
  } catch {
    return [];
  }
}

export const differences = new Differences();
