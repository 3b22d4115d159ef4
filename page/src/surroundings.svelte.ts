// What is about the chair now: the ring of directions, and the reason on display with its cause.

import { causeOf, doorBy, ring, type Cause, type Direction } from "./around";
import { chair } from "./chair.svelte";
import { distance } from "./map/strokes";
import { isMoving } from "./input/switches";
import { nearestEdge } from "./map/edges";
import { mapView } from "./map/mapView.svelte";
import type { ReasonText } from "./messages";
import { READ, SILENT, told } from "./reasonDisplay";
import { slowFor, type Slowness } from "./slowed";

/** Reasons whose cause is something about the chair. */
const CAUSED = new Set([
  "too_close", "blocked", "waiting", "no_safe_plan", "replanning", "creeping", "backing_up", "ask_rider", "no_path",
]);
/** A cause stays pointed at so long although another one is nearer for a moment, ms (assumed). */
const KEEPS = 1_000;
/** Rates of time below which a computer is slow, and above which it is not any more (assumed). */
const SLOW = 0.8;
const FAST = 0.95;
/** So long either must last before it is told, ms (assumed). */
const PACE_LASTS = 3_000;
/** So long it is slow for something before that is said, and so long it stays to be read, ms (assumed). */
const SLOWED_LASTS = 1_000;
/** So long it must stand, or drive, before the page says so, ms (assumed): a jerk is not felt as a stop. */
const STANDS_LASTS = 400;
/** What is nearer to the middle of the chair than this, ahead of it, is close, m (assumed). */
const CLOSE = 1.5;
/** Reasons whose cause is an edge of the floor, within this of the middle of the chair, m (assumed). */
const AT_EDGES = new Set(["edge_ahead", "floor_unseen", "edges_allowed"]);
const AT_EDGE = 2;
const RING = "cohelm.ring";

class Surroundings {
  ring = $state.raw<readonly Direction[]>([]);
  saying = $state.raw(SILENT);
  cause = $state.raw<Cause | null>(null);
  /** True if the ring is shown about chair and joystick. */
  shown = $state(kept());
  /** True while this computer is too slow for real time, and that for some seconds. */
  slow = $state(false);
  /** True while the chair stands, short jerks left out. */
  stands = $state(true);
  /** The reason of a chair that tells one, or did a moment ago: it holds, and does not set off. */
  held = $state.raw<{ readonly reason: ReasonText; readonly cause: Cause | null } | null>(null);
  /** What is so close ahead that a chair without a reason sets off slowly. */
  close = $state.raw<Cause | null>(null);
  /** What the chair drives slowly for, short moments left out. */
  slowFor = $state.raw<Slowness | null>(null);
  /** What is ahead now; read when it is asked for. */
  ahead: Cause | null = null;
  #slowedAt = -Infinity;
  #reasonAt = -Infinity;
  #heldAt = -Infinity;
  #causedAt = -Infinity;
  /** Since when the reason is shown whose cause was looked for, ms. */
  #causeOf = -Infinity;
  #stoodAt = -Infinity;
  #pacedAt = -Infinity;

  show(on: boolean): void {
    this.shown = on;
    try {
      localStorage.setItem(RING, on ? "1" : "0");
    } catch {
      // A device that keeps nothing shows it again the next time.
    }
  }

  /** Called ten times a second. */
  look(now: number): void {
    const { state, scene } = chair;
    this.saying = told(this.saying, chair.stale ? null : chair.displayedState, now);
    if (!state || !scene || chair.stale) {
      this.ring = [];
      this.cause = null;
      this.slowFor = null;
      return;
    }
    this.#pace(state.rate ?? 1, now);
    if (isMoving(state) !== this.stands) this.#stoodAt = now;
    else if (now - this.#stoodAt > STANDS_LASTS) [this.stands, this.#stoodAt] = [!isMoving(state), now];
    const cause = causeOf(state, scene, chair.route.points, mapView.isWall);
    this.ahead = cause;
    const near = cause && distance(cause.at, [state.pose[0], state.pose[1]]) < CLOSE ? cause : null;
    if (near?.thing !== this.close?.thing || near?.moves !== this.close?.moves) this.close = near;
    this.#hold(chair.displayedState?.reason ?? null, cause, now);
    const slowed = this.saying.shown ? null : slowFor(state, cause, chair.limits?.max_speed ?? Infinity);
    if (slowed === this.slowFor) this.#slowedAt = now;
    else if (now - this.#slowedAt > SLOWED_LASTS) [this.slowFor, this.#slowedAt] = [slowed, now];
    this.ring = this.shown ? ring(state, scene, mapView.isWall) : [];
    const code = this.saying.shown?.code ?? "";
    if (!CAUSED.has(code)) {
      const edge = AT_EDGES.has(code) && nearestEdge(state.pose, chair.edges, AT_EDGE);
      this.cause = edge ? { thing: "edge", at: edge } : null;
      return;
    }
    const { goal } = state;
    // Where there is no route, nothing about the chair is the cause, but a shut door may be.
    const found = code === "no_path" ? goal && doorBy(state, scene, [goal.x, goal.y]) : cause;
    // Its words stay for a while, its place follows at once.
    const held = this.#causeOf === this.saying.since && now - this.#causedAt < KEEPS;
    if (held && found?.thing === this.cause?.thing && found) this.cause = { ...this.cause!, at: found.at };
    if (held) return;
    this.#causedAt = now;
    this.#causeOf = this.saying.since;
    this.cause = found;
  }

  /** A reason too short to be displayed is kept until it can be read, so that a chair that stands can name it. */
  #hold(reason: ReasonText | null, cause: Cause | null, now: number): void {
    if (reason) this.#reasonAt = now;
    if (now - this.#reasonAt >= KEEPS) this.held = null;
    if (!reason || reason.code === this.held?.reason.code || (this.held && now - this.#heldAt < READ)) return;
    this.held = { reason, cause: CAUSED.has(reason.code) ? cause : null };
    this.#heldAt = now;
  }

  /** Told only after it has lasted, and until it is over for as long. */
  #pace(rate: number, now: number): void {
    const other = this.slow ? rate > FAST : rate < SLOW;
    if (!other) this.#pacedAt = now;
    else if (now - this.#pacedAt > PACE_LASTS) [this.slow, this.#pacedAt] = [!this.slow, now];
  }
}

function kept(): boolean {
  try {
    return localStorage.getItem(RING) !== "0";
  } catch {
    return true;
  }
}

export const surroundings = new Surroundings();
