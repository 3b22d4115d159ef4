// Selected point on the map, and the line that is drawn on it.

import { link, type Answer } from "./link";
import type { Point } from "./map/view";
import type { PlaceInfo } from "./messages";

export type Tool = "look" | "this-way" | "not-this-way";

export interface Touched {
  readonly point: Point;
  /** The place that it is, if it is one. */
  readonly place: PlaceInfo | null;
}

export class MapSelection {
  tool = $state<Tool>("look");
  touched = $state.raw<Touched | null>(null);
  /** The line that is being drawn, on the map. */
  line = $state.raw<readonly Point[] | null>(null);
  /** Why the last thing asked was not done. */
  refusal = $state("");
  /** Takes a drawn line. */
  drawing: (line: readonly Point[], avoided: boolean) => void = () => undefined;

  /** True while something on the map is being selected, so that the map must be visible. */
  readonly busy = $derived(this.tool !== "look" || this.touched !== null);

  touch(point: Point, place: PlaceInfo | null): void {
    this.touched = { point, place };
  }

  /** A line was drawn: the tool says what it means. */
  stroke(line: readonly Point[]): void {
    const { tool } = this;
    this.line = null;
    this.tool = "look";
    if (tool !== "look") this.drawing(line, tool === "not-this-way");
  }

  cancel(): void {
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
