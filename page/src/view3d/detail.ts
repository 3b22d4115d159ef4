// How finely the picture is drawn: less where a computer cannot keep up.

/** Slower than this the picture gets coarser, frames a second (assumed: 30 with some to spare). */
const ENOUGH = 34;
const FRAMES = 24;
const COARSER = 0.8;
export const COARSEST = 0.5;

export class Detail {
  #gaps: number[] = [];
  #last = -Infinity;

  constructor(
    /** Pixels of the picture for each of the page. */
    public ratio: number,
  ) {}

  /** Nothing moves: the time until the next frame is nobody's fault. */
  pause(): void {
    this.#last = -Infinity;
  }

  /** A frame was drawn at this time, ms; true if the ratio has changed. */
  drawn(now: number): boolean {
    const gap = now - this.#last;
    this.#last = now;
    if (gap === Infinity) return false;
    this.#gaps.push(gap);
    if (this.#gaps.length < FRAMES) return false;
    const mean = this.#gaps.reduce((sum, each) => sum + each, 0) / FRAMES;
    this.#gaps = [];
    if (mean <= 1000 / ENOUGH || this.ratio <= COARSEST) return false;
    this.ratio = Math.max(COARSEST, this.ratio * COARSER);
    return true;
  }
}
