// The direction that is up on a map that turns with the chair: it follows calmly, as in a navigation device.

/** Time constant of following, s (assumed). */
const FOLLOWS = 0.7;
/** Maximum rate of turning, rad/s (assumed): 30 degrees. */
const RATE = 0.52;
/** Beyond this lag the rate may grow, so that ahead stays in the upper half, rad: 45 degrees. */
const LAG = Math.PI / 4;
/** Growth of the rate with the lag beyond that, 1/s (assumed). */
const CATCHES_UP = 2;
/** A chair that sways by less than this turns no map, rad (assumed): 3 degrees. */
const SWAYS = 0.05;
/** The map rests once it is so near, rad. */
const ARRIVED = 0.01;
/** Where motion is not wanted, the map is turned at once, and only by at least this, rad (assumed): 30 degrees. */
const STEP = Math.PI / 6;

/** Heading of the map, which follows that of the chair. */
export class MapHeading {
  #heading: number | null = null;
  #at = 0;
  /** True while the map turns without a new state. */
  turning = false;

  /** The next time it begins with the chair's heading. */
  reset(): void {
    this.#heading = null;
    this.turning = false;
  }

  /** Heading of the map, rad. to: that of the chair, rad.  now: ms.  still: motion is not wanted. */
  follow(to: number, now: number, still: boolean): number {
    const seconds = Math.max(0, now - this.#at) / 1_000;
    this.#at = now;
    if (this.#heading === null) return (this.#heading = to);
    const off = Math.atan2(Math.sin(to - this.#heading), Math.cos(to - this.#heading));
    const lag = Math.abs(off);
    if (still) {
      this.turning = false;
      if (lag > STEP) this.#heading = to;
      return this.#heading;
    }
    this.turning = lag > (this.turning ? ARRIVED : SWAYS);
    if (!this.turning) return this.#heading;
    const most = (RATE + CATCHES_UP * Math.max(0, lag - LAG)) * seconds;
    const wanted = lag * (1 - Math.exp(-seconds / FOLLOWS));
    this.#heading += Math.sign(off) * Math.min(most, wanted);
    return this.#heading;
  }
}
