// What a rider points at on the map, and what a wish would cost before it is made.

import { chair } from "./chair.svelte";
import { link, PRICE_WITHIN, type Answer } from "./link";
import { drawn, zoneOf } from "./map/strokes";
import type { Point } from "./map/view";
import type { Place, Preview, Want } from "./messages";

export type Tool = "look" | "this-way" | "not-this-way";
export type Wish = Pick<Want, "kind" | "points"> & { radius: number };

export interface Touched {
  readonly point: Point;
  /** The place that it is, if it is one. */
  readonly place: Place | null;
}

/** A wish that waits for its price and for the rider's word. */
export interface Proposal {
  readonly wish: Wish;
  readonly words: string;
  readonly price: Preview | null;
  readonly trouble: string;
}

/** How far about a place "not by" reaches, m. */
const BY = 1.5;

export class Choosing {
  tool = $state<Tool>("look");
  touched = $state.raw<Touched | null>(null);
  proposal = $state.raw<Proposal | null>(null);
  /** The line that is being drawn, on the map. */
  line = $state.raw<readonly Point[] | null>(null);
  /** Why the last thing asked was not done. */
  refusal = $state("");

  /** Whether something about the map is being chosen, so that the map is to be seen. */
  readonly busy = $derived(this.tool !== "look" || this.proposal !== null || this.touched !== null);

  touch(point: Point, place: Place | null): void {
    this.proposal = null;
    this.touched = { point, place };
  }

  /** A line was drawn: the tool says what it means. */
  stroke(line: readonly Point[]): void {
    const { tool } = this;
    this.line = null;
    this.tool = "look";
    if (tool === "not-this-way") {
      void this.propose({ kind: "avoid", ...zoneOf(line) }, "Not this way");
    } else if (tool === "this-way") {
      const points = drawn(line);
      void this.propose({ kind: "stroke", points, radius: 0 }, "Go this way");
    }
  }

  by(point: Point, name: string): Promise<void> {
    return this.propose({ kind: "attract", points: [point], radius: 0 }, `Go by ${name}`);
  }

  notBy(point: Point, name: string): Promise<void> {
    return this.propose({ kind: "avoid", points: [point], radius: BY }, `Not by ${name}`);
  }

  async propose(wish: Wish, words: string): Promise<void> {
    this.touched = null;
    const proposal: Proposal = { wish, words, price: null, trouble: "" };
    this.proposal = proposal;
    if (!chair.goal) return;
    const answer = await link.ask({ type: "want", ...wish, preview: true }, PRICE_WITHIN);
    if (this.proposal !== proposal) return;
    if (answer.type === "preview") {
      this.proposal = { ...proposal, price: answer, trouble: answer.trouble };
    } else if (answer.type === "refused") {
      this.proposal = { ...proposal, trouble: answer.text };
    }
  }

  async confirm(): Promise<void> {
    const { proposal } = this;
    if (!proposal) return;
    this.proposal = null;
    this.heed(await link.ask({ type: "want", ...proposal.wish, preview: false }));
  }

  cancel(): void {
    this.proposal = null;
    this.touched = null;
    this.line = null;
    this.tool = "look";
  }

  async go(to: { place: string } | { point: Point } | null): Promise<void> {
    this.cancel();
    this.heed(await link.ask({ type: "go", ...to }));
  }

  async ask(question: Parameters<typeof link.ask>[0]): Promise<boolean> {
    const answer = await link.ask(question);
    this.heed(answer);
    return answer.type !== "refused";
  }

  heed(answer: Answer): void {
    this.refusal = answer.type === "refused" ? answer.text : "";
  }
}

export const choosing = new Choosing();
