// The places' names on the screen: drawn once each, copied into every frame.

import type { PlaceInfo } from "../messages";
import { covers, placed, type Disc, type Label, type Placed } from "./labels";
import type { Colours } from "./palette";
import { toScreen, type View } from "./view";

const FONT = "500 13px system-ui, sans-serif";
const HEIGHT = 20;
const EDGE = 3;

export class Names {
  #made = new Map<string, HTMLCanvasElement>();
  #of: Colours | null = null;
  #ratio = 0;
  #known: { places: readonly PlaceInfo[]; view: View; shown: Placed[] } | null = null;

  draw(
    context: CanvasRenderingContext2D,
    places: readonly PlaceInfo[],
    colours: Colours,
    view: View,
    ratio: number,
    clear: readonly Disc[] = [],
    /** Width at the right that something covers, px. */
    covered = 0,
  ): void {
    if (colours !== this.#of || ratio !== this.#ratio) {
      this.#made.clear();
      this.#of = colours;
      this.#ratio = ratio;
    }
    const [dx, dy] = this.#moved(places, view);
    const edge = context.canvas.width / ratio - EDGE - covered;
    for (const { label, x, y } of this.#known!.shown) {
      // A name that the edge cuts cannot be read.
      if (x + dx - label.width / 2 < EDGE || x + dx + label.width / 2 > edge) continue;
      if (clear.some((disc) => covers(label, x + dx, y + dy, disc))) continue;
      const image = this.#image(label.name);
      context.drawImage(
        image,
        x + dx - label.width / 2 - EDGE,
        y + dy - HEIGHT / 2,
        image.width / ratio,
        image.height / ratio,
      );
    }
  }

  /** Places them anew unless the map has only been moved, and says by how much that was, px. */
  #moved(places: readonly PlaceInfo[], view: View): readonly [number, number] {
    const known = this.#known;
    if (known?.places === places && known.view.scale === view.scale && known.view.turn === view.turn) {
      const [x, y] = toScreen(view, ...known.view.at);
      return [x - known.view.middle[0], y - known.view.middle[1]];
    }
    const labels = places.map((place): Label => {
      const [x, y] = toScreen(view, place.x, place.y);
      const width = this.#image(place.name).width / this.#ratio - 2 * EDGE;
      return { name: place.name, x, y, width, height: HEIGHT - 4 };
    });
    this.#known = { places, view, shown: placed(labels, known?.places === places ? known.shown : []) };
    return [0, 0];
  }

  #image(name: string): HTMLCanvasElement {
    const kept = this.#made.get(name);
    if (kept) return kept;
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("2d")!;
    context.font = FONT;
    canvas.width = Math.ceil((context.measureText(name).width + 2 * EDGE) * this.#ratio);
    canvas.height = Math.ceil(HEIGHT * this.#ratio);
    context.scale(this.#ratio, this.#ratio);
    context.font = FONT;
    context.textBaseline = "middle";
    context.lineJoin = "round";
    context.lineWidth = 4;
    context.strokeStyle = this.#of!.free;
    context.fillStyle = this.#of!.text;
    context.strokeText(name, EDGE, HEIGHT / 2);
    context.fillText(name, EDGE, HEIGHT / 2);
    this.#made.set(name, canvas);
    return canvas;
  }
}
