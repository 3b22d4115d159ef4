// Between two states of the chair, twenty a second, the picture moves on evenly.

import type { PersonInfo, ChairState } from "../messages";

/** Moving parts of a state. */
export interface Shown {
  readonly pose: ChairState["pose"];
  readonly people: readonly PersonInfo[];
  readonly true_people: ChairState["true_people"];
}

/** A longer way in one state is a jump, which is not drawn as a movement, m. */
const JUMP = 1;
const SHORTEST = 25;
const LONGEST = 120;

/** True if the chair has a pose: while it starts, there may be no world yet. */
export function placed({ pose, reason }: Pick<ChairState, "pose" | "reason">): boolean {
  return reason?.code !== "starting" || pose.some((part) => part !== 0);
}

const mixed = (a: number, b: number, share: number): number => a + share * (b - a);

export function mixedAngle(a: number, b: number, share: number): number {
  const turn = Math.atan2(Math.sin(b - a), Math.cos(b - a));
  return a + share * turn;
}

/** `share` of the way from one to the next; who was not there before is where they are. */
export function between(a: Shown, b: Shown, share: number): Shown {
  if (share >= 1 || far(a.pose, b.pose)) return b;
  const before = new Map(a.people.map((person) => [person.id, person]));
  return {
    pose: [
      mixed(a.pose[0], b.pose[0], share),
      mixed(a.pose[1], b.pose[1], share),
      mixedAngle(a.pose[2], b.pose[2], share),
    ],
    people: b.people.map((now) => moved(before.get(now.id), now, share)),
    true_people: b.true_people,
  };
}

function moved(was: PersonInfo | undefined, now: PersonInfo, share: number): PersonInfo {
  if (!was || far([was.x, was.y], [now.x, now.y])) return now;
  return {
    ...now,
    x: mixed(was.x, now.x, share),
    y: mixed(was.y, now.y, share),
    axis: mixedAngle(was.axis, now.axis, share),
    front: mixed(was.front, now.front, share),
    side: mixed(was.side, now.side, share),
    rear: mixed(was.rear, now.rear, share),
  };
}

function far(a: readonly number[], b: readonly number[]): boolean {
  return Math.hypot((a[0] ?? 0) - (b[0] ?? 0), (a[1] ?? 0) - (b[1] ?? 0)) > JUMP;
}

/** Moves from what was shown when a state came to that state, in as long as states take. */
export class Motion {
  #from: Shown | null = null;
  #to: Shown | null = null;
  #came = 0;
  #span = 50;

  put(state: Shown, now: number): void {
    this.#from = this.at(now);
    if (this.#to) this.#span = Math.min(LONGEST, Math.max(SHORTEST, now - this.#came));
    this.#to = state;
    this.#came = now;
  }

  at(now: number, still = false): Shown | null {
    if (!this.#to || !this.#from || still) return this.#to;
    // A frame may be dated before the state that came while it waited.
    const share = Math.max(0, (now - this.#came) / this.#span);
    return between(this.#from, this.#to, share);
  }

  /** True if the picture still changes without a new state. */
  moving(now: number): boolean {
    return this.#to !== null && now - this.#came < this.#span;
  }
}
