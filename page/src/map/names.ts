// The places' names on the screen: drawn once each, copied into every frame.

import type { IsWall } from "../around";
import type { PlaceInfo } from "../messages";
import { covers, placed, type Disc, type Label, type Placed } from "./labels";
import type { Colours } from "./palette";
import { toMap, toScreen, type View } from "./view";

const FONT = "500 13px system-ui, sans-serif";
const HEIGHT = 20;
const EDGE = 3;

/** Radius of the dot that stands for a name without room, px. */
const DOT = 3;
/** Columns and rows at which a label is tested for walls. */
const COLUMNS = [-0.5, -0.3, -0.1, 0.1, 0.3, 0.5];
const ROWS = [-0.5, 0, 0.5];

/** What is about the names. */
interface Surroundings {
  readonly ratio: number;
  readonly clear: readonly Disc[];
  /** Width at the right that something covers, px. */
  readonly covered: number;
  readonly isWall: IsWall;
}

export class Names {
  #made = new Map<string, HTMLCanvasElement>();
  #of: Colours | null = null;
  #ratio = 0;
  #known: { places: readonly PlaceInfo[]; view: View; isWall: IsWall; shown: Placed[] } | null = null;

  draw(
    context: CanvasRenderingContext2D,
    places: readonly PlaceInfo[],
    colours: Colours,
    view: View,
    { ratio, clear, covered, isWall }: Surroundings,
  ): void {
    if (colours !== this.#of || ratio !== this.#ratio) {
      this.#made.clear();
      this.#of = colours;
      this.#ratio = ratio;
    }
    const [dx, dy] = this.#moved(places, view, isWall);
    const edge = context.canvas.width / ratio - EDGE - covered;
    const shown = new Set<string>();
    for (const { label, x, y } of this.#known!.shown) {
      // A name that the edge cuts cannot be read.
      if (x + dx - label.width / 2 < EDGE || x + dx + label.width / 2 > edge) continue;
      if (clear.some((disc) => covers(label, x + dx, y + dy, disc))) continue;
      shown.add(label.name);
      const image = this.#image(label.name);
      context.drawImage(
        image,
        x + dx - label.width / 2 - EDGE,
        y + dy - HEIGHT / 2,
        image.width / ratio,
        image.height / ratio,
      );
    }
    context.fillStyle = colours.text;
    for (const { name, x, y } of places) {
      if (shown.has(name)) continue;
      const at = toScreen(view, x, y);
      if (clear.some((disc) => covers({ width: 0, height: 0 }, ...at, disc))) continue;
      context.beginPath();
      context.arc(...at, DOT, 0, 2 * Math.PI);
      context.fill();
    }
  }

  /** Places them anew unless the map has only been moved, and says by how much that was, px. */
  #moved(places: readonly PlaceInfo[], view: View, isWall: IsWall): readonly [number, number] {
    const known = this.#known;
    if (known?.places === places && known.isWall === isWall && known.view.scale === view.scale && known.view.turn === view.turn) {
      const [x, y] = toScreen(view, ...known.view.at);
      return [x - known.view.middle[0], y - known.view.middle[1]];
    }
    const labels = places.map((place): Label => {
      const [x, y] = toScreen(view, place.x, place.y);
      const width = this.#image(place.name).width / this.#ratio - 2 * EDGE;
      return { name: place.name, x, y, width, height: HEIGHT - 4 };
    });
    const tests = COLUMNS.length * ROWS.length;
    const walled = ({ label: { width, height }, x, y }: Placed): number =>
      COLUMNS.reduce((sum, c) => sum + ROWS.filter((r) => isWall(...toMap(view, x + c * width, y + r * height))).length, 0) / tests;
    this.#known = { places, view, isWall, shown: placed(labels, known?.places === places ? known.shown : [], walled) };
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
