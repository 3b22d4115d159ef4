// Gestures on the map: tap, drag, pinch, drawn line.

import type { Point } from "./view";

export interface Meaning {
  tap(at: Point): void;
  pan(dx: number, dy: number): void;
  zoom(factor: number, at: Point): void;
  /** A line grows; it is called with all of it. */
  draw(line: readonly Point[]): void;
  /** The line is done, or was none after all. */
  drawn(line: readonly Point[] | null): void;
}

/** A finger that moves less than this has touched, px. */
const SHAKE = 9;

export class Gestures {
  /** True if one finger draws instead of moving the map. */
  drawing = false;
  #fingers = new Map<number, Point>();
  #start: Point | null = null;
  #moved = false;
  #line: Point[] | null = null;

  constructor(readonly meaning: Meaning) {}

  down(id: number, at: Point): void {
    this.#fingers.set(id, at);
    if (this.#fingers.size === 1) {
      this.#start = at;
      this.#moved = false;
      this.#line = this.drawing ? [at] : null;
    } else {
      this.#moved = true;
      this.#giveUp();
    }
  }

  move(id: number, at: Point): void {
    const was = this.#fingers.get(id);
    if (!was) return;
    if (this.#fingers.size > 1) {
      this.#pinch(id, at);
      return;
    }
    if (!this.#moved && this.#start && apart(this.#start, at) < SHAKE) return;
    this.#moved = true;
    this.#fingers.set(id, at);
    if (this.#line) {
      this.#line.push(at);
      this.meaning.draw(this.#line);
    } else {
      this.meaning.pan(at[0] - was[0], at[1] - was[1]);
    }
  }

  up(id: number, at: Point): void {
    if (!this.#fingers.delete(id) || this.#fingers.size > 0) return;
    const line = this.#line;
    this.#line = null;
    if (!this.#moved) {
      if (line) this.meaning.drawn(null);
      this.meaning.tap(at);
    } else if (line) this.meaning.drawn(line);
  }

  cancel(id: number): void {
    this.#fingers.delete(id);
    this.#moved = true;
    this.#giveUp();
  }

  #giveUp(): void {
    if (this.#line) this.meaning.drawn(null);
    this.#line = null;
  }

  #pinch(id: number, at: Point): void {
    const other = [...this.#fingers].find(([each]) => each !== id)![1];
    const was = this.#fingers.get(id)!;
    this.#fingers.set(id, at);
    const before = middle(was, other);
    const now = middle(at, other);
    this.meaning.pan(now[0] - before[0], now[1] - before[1]);
    this.meaning.zoom(apart(at, other) / Math.max(1, apart(was, other)), now);
  }
}

function apart(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

function middle(a: Point, b: Point): Point {
  return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
}
