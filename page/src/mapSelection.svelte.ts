// Selected point on the map, and the price of a route preference before it is applied.

import { chair } from "./chair.svelte";
import { link, PRICE_WITHIN, type Answer } from "./link";
import { drawn, zoneOf } from "./map/strokes";
import type { Point } from "./map/view";
import type { PlaceInfo, WishPreview, AddWish } from "./messages";

export type Tool = "look" | "this-way" | "not-this-way";
export type Wish = Pick<AddWish, "kind" | "points"> & { radius: number };

export interface Touched {
  readonly point: Point;
  /** The place that it is, if it is one. */
  readonly place: PlaceInfo | null;
}

/** A wish that waits for its price and for the rider's word. */
export interface Proposal {
  readonly wish: Wish;
  readonly words: string;
  readonly price: WishPreview | null;
  readonly trouble: string;
}

/** Radius of the area to avoid about a place, m. */
const BY = 1.5;

export class MapSelection {
  tool = $state<Tool>("look");
  touched = $state.raw<Touched | null>(null);
  proposal = $state.raw<Proposal | null>(null);
  /** The line that is being drawn, on the map. */
  line = $state.raw<readonly Point[] | null>(null);
  /** Why the last thing asked was not done. */
  refusal = $state("");

  /** True while something on the map is being selected, so that the map must be visible. */
  readonly busy = $derived(this.tool !== "look" || this.proposal !== null || this.touched !== null);

  touch(point: Point, place: PlaceInfo | null): void {
    this.proposal = null;
    this.touched = { point, place };
  }

  /** A line was drawn: the tool says what it means. */
  stroke(line: readonly Point[]): void {
    const { tool } = this;
    this.line = null;
    this.tool = "look";
    if (tool === "not-this-way") {
      void this.propose({ kind: "avoid", ...zoneOf(line) }, "Avoid this area");
    } else if (tool === "this-way") {
      const points = drawn(line);
      void this.propose({ kind: "stroke", points, radius: 0 }, "Follow this line");
    }
  }

  by(point: Point, name: string): Promise<void> {
    return this.propose({ kind: "attract", points: [point], radius: 0 }, `Go via ${name}`);
  }

  notBy(point: Point, name: string): Promise<void> {
    return this.propose({ kind: "avoid", points: [point], radius: BY }, `Avoid ${name}`);
  }

  async propose(wish: Wish, words: string): Promise<void> {
    this.touched = null;
    const proposal: Proposal = { wish, words, price: null, trouble: "" };
    this.proposal = proposal;
    if (!chair.goal) return;
    const answer = await link.ask({ type: "add_wish", ...wish, preview: true }, PRICE_WITHIN);
    if (this.proposal !== proposal) return;
    if (answer.type === "wish_preview") {
      this.proposal = { ...proposal, price: answer, trouble: answer.error };
    } else if (answer.type === "rejected") {
      this.proposal = { ...proposal, trouble: answer.text };
    }
  }

  async confirm(): Promise<void> {
    const { proposal } = this;
    if (!proposal) return;
    this.proposal = null;
    this.heed(await link.ask({ type: "add_wish", ...proposal.wish, preview: false }));
  }

  cancel(): void {
    this.proposal = null;
    this.touched = null;
    this.line = null;
    this.tool = "look";
  }

  async go(to: { place: string } | { point: Point } | null): Promise<void> {
    this.cancel();
    this.heed(await link.ask({ type: "set_goal", ...to }));
  }

  async ask(question: Parameters<typeof link.ask>[0]): Promise<boolean> {
    const answer = await link.ask(question);
    this.heed(answer);
    return answer.type !== "rejected";
  }

  heed(answer: Answer): void {
    this.refusal = answer.type === "rejected" ? answer.text : "";
  }
}

export const selection = new MapSelection();
