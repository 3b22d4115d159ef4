// The map's picture in the page's colours, with smooth edges however near one looks.

import type { FloorInfo, PlaceInfo, SceneInfo } from "../messages";
import { kindOf } from "../places";
import { rgbOf, type Colours, type Rgb } from "./palette";
import type { Box } from "./view";

/** The tinted picture has at most so many pixels. */
const MOST = 6_000_000;
/** Finer than this nobody sees, pixels a cell. */
const FINEST = 3;

export async function loadFloor(floor: FloorInfo): Promise<HTMLImageElement> {
  const image = new Image();
  image.src = floor.image;
  await image.decode();
  return image;
}

/** 0 is a wall, 128 unknown, 255 free; enlarged smoothly, edges lie where the grey is half. */
export function tinted(image: HTMLImageElement, colours: Colours): HTMLCanvasElement {
  const { naturalWidth: width, naturalHeight: height } = image;
  const fine = Math.max(1, Math.min(FINEST, Math.floor(Math.sqrt(MOST / (width * height)))));
  const canvas = document.createElement("canvas");
  canvas.width = width * fine;
  canvas.height = height * fine;
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.imageSmoothingQuality = "high";
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
  tint(pixels.data, colours);
  context.putImageData(pixels, 0, 0);
  return canvas;
}

/** The picture with its rooms in a calm colour of their kind; passages stay as they are. */
export function withRooms(
  picture: HTMLCanvasElement,
  { x, y, width, height, resolution }: FloorInfo,
  places: readonly PlaceInfo[],
  colours: Colours,
): HTMLCanvasElement {
  const context = picture.getContext("2d")!;
  const perMetre = picture.width / (width * resolution);
  const upper = y + height * resolution;
  const light = brightness(rgbOf(colours.free)) > brightness(rgbOf(colours.wall));
  context.save();
  // The floor takes the colour; walls, which are darker than it or lighter, stay as they are.
  context.globalCompositeOperation = light ? "darken" : "lighten";
  for (const { name, area } of places) {
    const kind = kindOf(name);
    if (area.length < 3 || !kind) continue;
    context.fillStyle = colours[kind.slice("places.".length) as RoomKind];
    context.beginPath();
    for (const [px, py] of area) context.lineTo((px - x) * perMetre, (upper - py) * perMetre);
    context.fill();
  }
  context.restore();
  return picture;
}

export type RoomKind = "wards" | "toilets" | "food" | "care" | "ways" | "other";

function brightness([r, g, b]: Rgb): number {
  return r + g + b;
}

function tint(data: Uint8ClampedArray, colours: Colours): void {
  const shades = shadesOf(rgbOf(colours.wall), rgbOf(colours.unknown), rgbOf(colours.free));
  for (let k = 0; k < data.length; k += 4) {
    const at = 3 * data[k]!;
    data[k] = shades[at]!;
    data[k + 1] = shades[at + 1]!;
    data[k + 2] = shades[at + 2]!;
  }
}

/** For each grey its colour: three flats, with steep ramps between them. */
export function shadesOf(wall: Rgb, unknown: Rgb, free: Rgb): Uint8ClampedArray {
  const shades = new Uint8ClampedArray(3 * 256);
  for (let grey = 0; grey < 256; grey++) {
    const toUnknown = ramp(grey, 52, 76);
    const toFree = ramp(grey, 140, 190);
    for (let c = 0; c < 3; c++) {
      const dark = wall[c]! + toUnknown * (unknown[c]! - wall[c]!);
      shades[3 * grey + c] = dark + toFree * (free[c]! - dark);
    }
  }
  return shades;
}

function ramp(x: number, from: number, to: number): number {
  return Math.min(1, Math.max(0, (x - from) / (to - from)));
}

/** The whole floor. */
export function floorBox({ floor: { x, y, width, height, resolution } }: Pick<SceneInfo, "floor">): Box {
  return { x, y, width: width * resolution, height: height * resolution };
}
