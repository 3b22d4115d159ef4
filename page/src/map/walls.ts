// Walls of the map, read from its picture.

import type { IsWall } from "../around";
import type { FloorInfo } from "../messages";

/** A wall within this distance counts, m: ranges are measured, maps are drawn (assumed). */
const NEAR = 0.3;
/** Darker is a wall: 0 is one, 128 unknown, 255 free. */
const DARK = 64;

export interface Walls {
  /** A wall is in this cell. */
  readonly at: IsWall;
  /** One is within 0.3 m. */
  readonly near: IsWall;
}

/** Of a map that is still being loaded. */
export const NO_WALLS: Walls = { at: () => false, near: () => false };

export function wallsOf(image: HTMLImageElement, floor: FloorInfo): Walls {
  const canvas = document.createElement("canvas");
  canvas.width = floor.width;
  canvas.height = floor.height;
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, floor.width, floor.height);
  const dark = (col: number, row: number): boolean => data[4 * (row * floor.width + col)]! < DARK;
  return { at: wallsIn(dark, floor, 0), near: wallsIn(dark, floor) };
}

/** The same from any picture; its first row is at the top of the map. */
export function wallsIn(dark: (col: number, row: number) => boolean, floor: FloorInfo, near = NEAR): IsWall {
  const reach = Math.ceil(near / floor.resolution);
  return (x, y) => {
    const col = Math.floor((x - floor.x) / floor.resolution);
    const row = floor.height - 1 - Math.floor((y - floor.y) / floor.resolution);
    for (let c = Math.max(0, col - reach); c <= Math.min(floor.width - 1, col + reach); c++) {
      for (let r = Math.max(0, row - reach); r <= Math.min(floor.height - 1, row + reach); r++) {
        if (dark(c, r)) return true;
      }
    }
    return false;
  };
}
