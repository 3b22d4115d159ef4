import { Box3, Color, Mesh, Vector3, type BufferGeometry } from "three";
import { describe, expect, it } from "vitest";
import type { Colours } from "../map/palette";
import type { Point } from "../map/view";
import type { SceneInfo } from "../messages";
import { areaOf } from "./contours";
import { bar, building, furnitureBatch, smaller, wallBatch, wallsOf } from "./building";
import type { FloorSolids, SolidShape } from "./floorSolids";
import { Batch, painted } from "./solids";

const COLOURS = new Proxy({}, { get: () => "#808080" }) as Colours;
const SQUARE: Point[] = [[1, 2], [3, 2], [3, 5], [1, 5]];

function boxOf(geometry: BufferGeometry): { low: number[]; high: number[] } {
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox!;
  return { low: min.toArray(), high: max.toArray() };
}

/** Area of all triangles whose normal has this direction. */
function facing(geometry: BufferGeometry, direction: Vector3): number {
  const at = geometry.getAttribute("position");
  const index = geometry.index!;
  let sum = 0;
  for (let k = 0; k < index.count; k += 3) {
    const [a, b, c] = [0, 1, 2].map((n) => new Vector3().fromBufferAttribute(at, index.getX(k + n))) as [Vector3, Vector3, Vector3];
    const normal = b.sub(a).cross(c.sub(a)).multiplyScalar(0.5);
    if (normal.clone().normalize().dot(direction) > 0.99) sum += normal.length();
  }
  return sum;
}

/** A room of 4 × 3 m, its walls 0.5 m thick, with a table of 1 m in it; 0.5 m a pixel. */
function room(): { scene: SceneInfo; pixels: ImageData } {
  const rows = ["########", "#......#", "#..##..#", "#..##..#", "#......#", "########"];
  const grey = rows.flatMap((row) => [...row].map((c) => (c === "#" ? 0 : 255)));
  const data = Uint8ClampedArray.from(grey.flatMap((each) => [each, each, each, 255]));
  const floor = { image: "", width: 8, height: 6, resolution: 0.5, x: 10, y: 20 };
  const doors = [{ id: 3, a: [10.25, 21], b: [10.25, 22] }];
  return { scene: { floor, doors } as unknown as SceneInfo, pixels: { data, width: 8, height: 6 } as ImageData };
}

const TABLE: SolidShape = {
  outline: [[11.5, 21], [12.5, 21], [12.5, 22], [11.5, 22]],
  height: 0.75,
  on_map: true,
  glass: false,
};
const solids = (...all: SolidShape[]): FloorSolids => ({ wall_height: 2.5, ceiling: true, solids: all, wet: [] });

describe("a prism", () => {
  const made = (outer: Point[], holes: Point[][] = []): Batch => {
    const batch = new Batch(COLOURS);
    batch.prism({ outer, holes }, 0.5, 2, painted(new Color("#ffffff")));
    return batch;
  };

  it("has two triangles a side and a top; z is up", () => {
    const batch = made(SQUARE);
    expect(batch.triangles).toBe(4 * 2 + 2);
    expect(boxOf(batch.geometry())).toEqual({ low: [1, 2, 0.5], high: [3, 5, 2] });
  });

  it("faces outwards, whichever way its outline is given", () => {
    for (const outline of [SQUARE, [...SQUARE].reverse()]) {
      const geometry = made(outline).geometry();
      // 2 × 3 m at the top; 1.5 m high sides of 3 m and of 2 m
      expect(facing(geometry, new Vector3(0, 0, 1))).toBeCloseTo(6);
      expect(facing(geometry, new Vector3(1, 0, 0))).toBeCloseTo(4.5);
      expect(facing(geometry, new Vector3(0, -1, 0))).toBeCloseTo(3);
      expect(facing(geometry, new Vector3(0, 0, -1))).toBe(0);
    }
  });

  it("has walls about its hole that face into it", () => {
    const hole: Point[] = [[1.5, 3], [2.5, 3], [2.5, 4], [1.5, 4]];
    const batch = made(SQUARE, [hole]);
    expect(batch.triangles).toBe(8 * 2 + 8); // a ring of 8 corners has 8 triangles
    expect(facing(batch.geometry(), new Vector3(0, 0, 1))).toBeCloseTo(6 - 1);
    expect(facing(batch.geometry(), new Vector3(1, 0, 0))).toBeCloseTo(1.5 * (3 + 1));
  });
});

describe("a building", () => {
  it("has walls where the map is occupied, in metres, and not where furniture stands", () => {
    const { scene, pixels } = room();
    const [ring, ...others] = wallsOf({ scene, pixels, solids: solids(TABLE) });
    expect(others).toEqual([]);
    expect(areaOf(ring!.outer)).toBeCloseTo(4 * 3);
    expect(ring!.holes.map(areaOf)).toEqual([-(3 * 2)]);
    expect(boxOf(wallBatch([ring!], COLOURS).geometry())).toEqual({ low: [10, 20, 0], high: [14, 23, 1] });
    expect(wallsOf({ scene, pixels, solids: solids() })).toHaveLength(2); // without it: a block in the room
  });

  it("has furniture of its height, and glass apart", () => {
    const table = furnitureBatch([TABLE, { ...TABLE, glass: true }], COLOURS);
    expect(table.triangles).toBe(2 * (4 * 2 + 2)); // body and top
    const { low, high } = boxOf(table.geometry());
    [11.5, 21, 0].forEach((each, k) => expect(low[k]).toBeCloseTo(each));
    [12.5, 22, 0.75].forEach((each, k) => expect(high[k]).toBeCloseTo(each));
  });

  it("is cut for the cameras above, and whole for the rider's eyes", () => {
    const { scene, pixels } = room();
    const made = building({ scene, pixels, solids: solids(TABLE), colours: COLOURS });
    const height = (): number => new Box3().setFromObject(made.group.children[0]!).max.z;
    made.cut(1.15);
    expect(height()).toBeCloseTo(1.15);
    made.cut(null);
    expect(height()).toBeCloseTo(2.5);
  });

  it("shows the doors that are closed", () => {
    const { scene, pixels } = room();
    const made = building({ scene, pixels, solids: solids(), colours: COLOURS });
    const meshes = (): number => {
      let count = 0;
      made.group.traverse((each) => void (each instanceof Mesh && each.visible && count++));
      return count;
    };
    const open = meshes();
    made.shut([3]);
    expect(meshes()).toBe(open + 1);
    made.shut([]);
    expect(meshes()).toBe(open);
  });
});

describe("outlines", () => {
  it("are set back on every side, whichever way they are given", () => {
    for (const outline of [SQUARE, [...SQUARE].reverse()]) {
      const inner = smaller(outline, 0.1);
      expect(Math.abs(areaOf(inner))).toBeCloseTo(1.8 * 2.8);
      expect(Math.min(...inner.map(([x]) => x))).toBeCloseTo(1.1);
    }
  });

  it("stay where nothing would be left of them", () => {
    const thin: Point[] = [[0, 0], [1, 0], [1, 0.05], [0, 0.05]];
    expect(smaller(thin, 0.035)).toBe(thin);
  });

  it("of a door lie on both sides of its line", () => {
    const { outer } = bar([0, 0], [0, 2], 0.2);
    expect(areaOf(outer)).toBeCloseTo(0.4);
    expect(outer.map(([x]) => Math.abs(x))).toEqual([0.1, 0.1, 0.1, 0.1]);
  });
});
