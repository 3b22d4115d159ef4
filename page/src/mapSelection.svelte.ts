// Selected point on the map, and the price of a route preference before it is applied.

import { chair } from "./chair.svelte";
import { t } from "./i18n/text.svelte";
import { link, PRICE_WITHIN, type Answer } from "./link";
import { drawn, zoneOf } from "./map/strokes";
import type { Point } from "./map/view";
import { avoidWish, viaWish, type Where } from "./wishes";
import type { PlaceInfo, WishPreview, AddWish } from "./messages";

export type Tool = "look" | "this-way" | "not-this-way";
export type Wish = Pick<AddWish, "kind" | "points"> & { radius: number; visit?: boolean };

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
  /** Where the chair was when the price was asked for. */
  readonly from: Point | null;
}

/** After this way a price is asked for anew, m: it is told from where the chair is. */
const STALE = 3;

export class MapSelection {
  tool = $state<Tool>("look");
  touched = $state.raw<Touched | null>(null);
  proposal = $state.raw<Proposal | null>(null);
  /** The line that is being drawn, on the map. */
  line = $state.raw<readonly Point[] | null>(null);
  /** Why the last thing asked was not done. */
  refusal = $state("");
  /** Takes a drawn line in place of this; returns whether it does. */
  drawing: (line: readonly Point[], avoided: boolean) => boolean = () => false;

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
    if (tool === "look" || this.drawing(line, tool === "not-this-way")) return;
    if (tool === "not-this-way") {
      void this.propose({ kind: "avoid", ...zoneOf(line) }, t("trip.avoidArea"));
    } else {
      const points = drawn(line);
      void this.propose({ kind: "stroke", points, radius: 0 }, t("trip.followLine"));
    }
  }

  by(place: Where): Promise<void> {
    const { wish, words } = viaWish(place);
    return this.propose(wish, words);
  }

  notBy(place: Where): Promise<void> {
    const { wish, words } = avoidWish(place);
    return this.propose(wish, words);
  }

  /** Wishes that were made while there was no trip: they are of the next one. */
  ahead: readonly Wish[] = [];

  async propose(wish: Wish, words: string): Promise<void> {
    this.touched = null;
    const pose = chair.state?.pose;
    const from = pose ? ([pose[0], pose[1]] as const) : null;
    const proposal: Proposal = { wish, words, price: null, trouble: "", from };
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

  /** Looks, from time to time, whether the chair has gone on since the price was told. */
  look(): void {
    const { proposal } = this;
    const pose = chair.state?.pose;
    if (!proposal?.price || !proposal.from || !pose) return;
    const gone = Math.hypot(pose[0] - proposal.from[0], pose[1] - proposal.from[1]);
    if (gone > STALE) void this.propose(proposal.wish, proposal.words);
  }

  async confirm(): Promise<void> {
    const { proposal } = this;
    if (!proposal) return;
    this.proposal = null;
    const ahead = !chair.goal || chair.state?.arrived === true;
    const answer = await link.ask({ type: "add_wish", ...proposal.wish, preview: false });
    this.heed(answer);
    if (ahead && answer.type !== "rejected") this.ahead = [...this.ahead, proposal.wish];
  }

  cancel(): void {
    this.proposal = null;
    this.touched = null;
    this.line = null;
    this.tool = "look";
  }

  /** Ends the trip. */
  async cancelTrip(): Promise<void> {
    this.cancel();
    this.heed(await link.ask({ type: "set_goal" }));
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
