// Upright prisms gathered in one geometry, so that a whole building is one draw call, with the light
// on them in their colours.

import { BufferGeometry, Color, Float32BufferAttribute, ShapeUtils, Vector2 } from "three";
import type { Point } from "../map/view";
import type { Colours } from "../map/palette";
import { areaOf, type Region } from "./contours";
import { lightOn } from "./light";

export interface Paint {
  readonly top: Color;
  readonly side: Color;
  /** Sides at their foot, darker than above: light is scarce there. */
  readonly foot: Color;
}

export class Batch {
  readonly #positions: number[] = [];
  readonly #colours: number[] = [];
  readonly #indices: number[] = [];

  /** `colours`: of the page, which colour the light too. */
  constructor(readonly colours: Colours) {}

  get triangles(): number {
    return this.#indices.length / 3;
  }

  /** An area from the height z0 to z1, m: its sides, and its top. */
  prism({ outer, holes }: Region, z0: number, z1: number, paint: Paint): void {
    const edge = areaOf(outer) < 0 ? [...outer].reverse() : outer;
    const inner = holes.map((hole) => (areaOf(hole) > 0 ? [...hole].reverse() : hole));
    for (const loop of [edge, ...inner]) this.#sides(loop, z0, z1, paint);
    this.#cap(edge, inner, z1, paint.top);
  }

  geometry(): BufferGeometry {
    const made = new BufferGeometry();
    made.setAttribute("position", new Float32BufferAttribute(this.#positions, 3));
    made.setAttribute("color", new Float32BufferAttribute(this.#colours, 3));
    made.setIndex(this.#indices);
    return made;
  }

  #vertex(x: number, y: number, z: number, colour: Color): number {
    this.#positions.push(x, y, z);
    this.#colours.push(colour.r, colour.g, colour.b);
    return this.#positions.length / 3 - 1;
  }

  /** The solid lies to the left of its edge. */
  #sides(loop: readonly Point[], z0: number, z1: number, { side, foot }: Paint): void {
    loop.forEach((a, k) => {
      const b = loop[(k + 1) % loop.length]!;
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length === 0) return;
      const light = lightOn([(b[1] - a[1]) / length, -(b[0] - a[0]) / length, 0], this.colours);
      const [low, high] = [foot.clone().multiply(light), side.clone().multiply(light)];
      const first = this.#vertex(a[0], a[1], z0, low);
      this.#vertex(b[0], b[1], z0, low);
      this.#vertex(b[0], b[1], z1, high);
      this.#vertex(a[0], a[1], z1, high);
      this.#indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    });
  }

  #cap(outer: readonly Point[], holes: readonly (readonly Point[])[], z: number, colour: Color): void {
    const vectors = (loop: readonly Point[]): Vector2[] => loop.map(([x, y]) => new Vector2(x, y));
    const first = this.#positions.length / 3;
    const lit = colour.clone().multiply(lightOn([0, 0, 1], this.colours));
    for (const [x, y] of [outer, ...holes].flat()) this.#vertex(x, y, z, lit);
    for (const triangle of ShapeUtils.triangulateShape(vectors(outer), holes.map(vectors))) {
      this.#indices.push(...triangle.map((index) => first + index));
    }
  }
}

/** Colours of a solid from that of its top. */
export function painted(colour: Color, side = 0.9, foot = 0.72): Paint {
  return {
    top: colour.clone(),
    side: colour.clone().multiplyScalar(side),
    foot: colour.clone().multiplyScalar(foot),
  };
}
