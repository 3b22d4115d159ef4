// Upright prisms gathered in one geometry, so that a whole building is one draw call.

import { BufferGeometry, Color, Float32BufferAttribute, ShapeUtils, Vector2 } from "three";
import type { Point } from "../map/view";
import { areaOf, type Region } from "./contours";

export interface Paint {
  readonly top: Color;
  readonly side: Color;
  /** Sides at their foot, darker than above: light is scarce there. */
  readonly foot: Color;
}

export class Batch {
  readonly #positions: number[] = [];
  readonly #normals: number[] = [];
  readonly #colours: number[] = [];
  readonly #indices: number[] = [];

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
    made.setAttribute("normal", new Float32BufferAttribute(this.#normals, 3));
    made.setAttribute("color", new Float32BufferAttribute(this.#colours, 3));
    made.setIndex(this.#indices);
    return made;
  }

  #vertex(x: number, y: number, z: number, normal: readonly number[], colour: Color): number {
    this.#positions.push(x, y, z);
    this.#normals.push(...normal);
    this.#colours.push(colour.r, colour.g, colour.b);
    return this.#positions.length / 3 - 1;
  }

  /** The solid lies to the left of its edge. */
  #sides(loop: readonly Point[], z0: number, z1: number, { side, foot }: Paint): void {
    loop.forEach((a, k) => {
      const b = loop[(k + 1) % loop.length]!;
      const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      if (length === 0) return;
      const out = [(b[1] - a[1]) / length, -(b[0] - a[0]) / length, 0];
      const low = this.#vertex(a[0], a[1], z0, out, foot);
      this.#vertex(b[0], b[1], z0, out, foot);
      this.#vertex(b[0], b[1], z1, out, side);
      this.#vertex(a[0], a[1], z1, out, side);
      this.#indices.push(low, low + 1, low + 2, low, low + 2, low + 3);
    });
  }

  #cap(outer: readonly Point[], holes: readonly (readonly Point[])[], z: number, colour: Color): void {
    const vectors = (loop: readonly Point[]): Vector2[] => loop.map(([x, y]) => new Vector2(x, y));
    const first = this.#positions.length / 3;
    for (const [x, y] of [outer, ...holes].flat()) this.#vertex(x, y, z, [0, 0, 1], colour);
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
