// What is about the chair now: the ring of directions, and the reason on display with its cause.

import { causeOf, doorBy, ring, type Cause, type Direction } from "./around";
import { chair } from "./chair.svelte";
import { isMoving } from "./input/switches";
import { mapView } from "./map/mapView.svelte";
import { SILENT, told } from "./reasonDisplay";
import { slowForPerson } from "./slowed";

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
/** So long it is slow for a person before that is said, and so long it stays to be read, ms (assumed). */
const SLOWED_LASTS = 1_000;
/** So long it must stand, or drive, before the page says so, ms (assumed): a jerk is not felt as a stop. */
const STANDS_LASTS = 400;
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
  /** True while the chair tells a reason, or did a moment ago: it holds, and does not set off. */
  held = $state(false);
  /** True while the chair drives slowly for a person, short moments left out. */
  slowForPerson = $state(false);
  #slowedAt = -Infinity;
  #reasonAt = -Infinity;
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
    this.saying = told(this.saying, chair.stale ? null : chair.toTell, now);
    if (!state || !scene || chair.stale) {
      this.ring = [];
      this.cause = null;
      this.slowForPerson = false;
      return;
    }
    this.#pace(state.rate ?? 1, now);
    if (state.reason) this.#reasonAt = now;
    this.held = now - this.#reasonAt < KEEPS;
    if (isMoving(state) !== this.stands) this.#stoodAt = now;
    else if (now - this.#stoodAt > STANDS_LASTS) this.stands = !isMoving(state);
    const slowed =
      !this.saying.shown &&
      slowForPerson(state, causeOf(state, scene, chair.route.points, mapView.isWall), chair.limits?.max_speed ?? Infinity);
    if (slowed === this.slowForPerson) this.#slowedAt = now;
    else if (now - this.#slowedAt > SLOWED_LASTS) this.slowForPerson = slowed;
    this.ring = this.shown ? ring(state, scene, mapView.isWall) : [];
    const code = this.saying.shown?.code ?? "";
    if (!CAUSED.has(code)) {
      this.cause = null;
      return;
    }
    const { goal } = state;
    // Where there is no route, nothing about the chair is the cause, but a shut door may be.
    const found =
      code === "no_path"
        ? goal && doorBy(state, scene, [goal.x, goal.y])
        : causeOf(state, scene, chair.route.points, mapView.isWall);
    // Its words stay for a while, its place follows at once.
    const held = this.#causeOf === this.saying.since && now - this.#causedAt < KEEPS;
    if (held && found?.thing === this.cause?.thing && found) this.cause = { ...this.cause!, at: found.at };
    if (held) return;
    this.#causedAt = now;
    this.#causeOf = this.saying.since;
    this.cause = found;
  }

  /** Told only after it has lasted, and until it is over for as long. */
  #pace(rate: number, now: number): void {
    const other = this.slow ? rate > FAST : rate < SLOW;
    if (!other) this.#pacedAt = now;
    else if (now - this.#pacedAt > PACE_LASTS) this.slow = !this.slow;
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
