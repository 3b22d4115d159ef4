// Places where the building differs from the map: which one the rider is told about, each once.

import { chair } from "./chair.svelte";
import { distance, distanceToSegment, lastOf } from "./map/strokes";
import type { Point } from "./map/view";
import type { ChairState, MapDifference, MapDifferences, SceneInfo } from "./messages";

/** A difference farther than this from the chair and from its route does not matter yet, m (assumed). */
const NEAR = 6;
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

/** The nearest difference by the chair or by the way ahead that has not been told; null: there is none. */
export function untold(
  found: readonly MapDifference[],
  told: readonly Told[],
  pose: ChairState["pose"],
  ahead: readonly Point[],
): MapDifference | null {
  const here: Point = [pose[0], pose[1]];
  const away = ({ x, y }: MapDifference): number =>
    Math.min(distance(here, [x, y]), ...ahead.map((point) => distance(point, [x, y])));
  const fresh = found.filter((each) => away(each) < NEAR && !told.some((other) => same(each, other)));
  const from = ({ x, y }: MapDifference): number => distance(here, [x, y]);
  return fresh.sort((a, b) => from(a) - from(b))[0] ?? null;
}

function same(a: Told, b: Told): boolean {
  return a.kind === b.kind && distance([a.x, a.y], [b.x, b.y]) < SAME;
}

/** So long a difference that asks for nothing covers the map, ms (assumed). */
const READ = 12_000;

class Differences {
  /** All that the map shows. */
  shown = $state.raw<readonly MapDifference[]>([]);
  /** The one that the rider is told about; it stays until it is closed or out of reach. */
  told = $state.raw<MapDifference | null>(null);
  /** Since when it is told, ms. */
  #toldAt = 0;
  #closed: readonly Told[] = stored();
  #of: MapDifferences | null = null;
  #shut = "";

  /** Called ten times a second. */
  look(): void {
    const { state, scene, differences } = chair;
    const shut = state?.closed_doors ?? [];
    if (scene && differences && (differences !== this.#of || shut.join() !== this.#shut)) {
      [this.#of, this.#shut] = [differences, shut.join()];
      this.shown = withoutDoors(differences.found, scene.doors, shut);
    }
    if (!state || this.shown.length === 0) {
      this.told = null;
      return;
    }
    const ahead = state.remaining == null ? [] : lastOf(chair.route.points, state.remaining);
    const { told } = this;
    const kept = told && untold(this.shown.filter((each) => same(each, told)), [], state.pose, ahead);
    const next = kept ?? untold(this.shown, this.#closed, state.pose, ahead);
    const now = performance.now();
    if (!next || !told || !same(next, told)) {
      this.told = next;
      this.#toldAt = now;
    } else if (told.kind === "gone" && now - this.#toldAt > READ) this.close(told); // it asks for nothing
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
