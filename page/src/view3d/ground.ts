// The floor: the map's picture on a plane, darker where walls and furniture keep the light away.

import {
  BufferGeometry,
  CanvasTexture,
  Float32BufferAttribute,
  LinearMipmapLinearFilter,
  LinearMipmapNearestFilter,
  Mesh,
  MeshBasicMaterial,
  SRGBColorSpace,
} from "three";
import { tinted } from "../map/floor";
import { rgbOf, type Colours } from "../map/palette";
import type { Point } from "../map/view";
import type { SolidShape } from "./floorSolids";
import type { Floor } from "./world";

/** Reach of the soft shadow beside a wall (assumed), m. */
const SHADOW = 0.45;
const SHADOW_STRENGTH = 0.34;
/** Side of a tile, m, and how much darker its joints are. */
const TILE = 1;
const TILE_STRENGTH = 0.13;

interface Picture extends Floor {
  readonly pixels: ImageData;
  readonly colours: Colours;
}

/** Grey pixels of the map's picture. */
export function pixelsOf(image: HTMLImageElement): ImageData {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

/** What the graphics card takes, or the processor in its stead. */
export interface TextureLimits {
  /** Longest side, px. */
  readonly most: number;
  /** True if smooth sampling costs little. */
  readonly fast: boolean;
}

/** The floor below walls and furniture. */
export function ground({ scene: { floor }, solids, image, pixels, colours }: Picture, { most, fast }: TextureLimits): Mesh {
  const picture = tinted(image, colours);
  const context = picture.getContext("2d")!;
  context.imageSmoothingQuality = "high";
  const perMetre = picture.width / (floor.width * floor.resolution);
  const [left, upper] = [floor.x, floor.y + floor.height * floor.resolution];
  cleared(context, solids.solids, ([x, y]) => [(x - left) * perMetre, (upper - y) * perMetre], colours.free);
  tiled(context, perMetre, colours);
  shaded(context, pixels, floor.resolution, colours);
  const texture = new CanvasTexture(fitting(picture, most));
  texture.colorSpace = SRGBColorSpace;
  texture.minFilter = fast ? LinearMipmapLinearFilter : LinearMipmapNearestFilter;
  texture.anisotropy = fast ? 4 : 1;
  const { x, y, width, height, resolution } = floor;
  const [right, top] = [x + width * resolution, y + height * resolution];
  const made = new BufferGeometry();
  const corners = [x, y, 0, right, y, 0, right, top, 0, x, top, 0];
  made.setAttribute("position", new Float32BufferAttribute(corners, 3));
  made.setAttribute("uv", new Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
  made.setIndex([0, 1, 2, 0, 2, 3]);
  return new Mesh(made, new MeshBasicMaterial({ map: texture }));
}

/** Furniture stands on free floor; on the map it has the colour of walls. */
function cleared(
  context: CanvasRenderingContext2D,
  solids: readonly SolidShape[],
  pixel: (point: Point) => Point,
  free: string,
): void {
  context.fillStyle = context.strokeStyle = free;
  context.lineWidth = 6;
  context.beginPath();
  for (const { outline, on_map } of solids) {
    if (!on_map) continue;
    outline.forEach((point, k) => (k === 0 ? context.moveTo(...pixel(point)) : context.lineTo(...pixel(point))));
    context.closePath();
  }
  context.fill();
  context.stroke();
}

/** Tiles: on an even floor one does not see that one moves. */
function tiled(context: CanvasRenderingContext2D, perMetre: number, colours: Colours): void {
  const { width, height } = context.canvas;
  context.strokeStyle = colours.wall;
  context.globalAlpha = TILE_STRENGTH;
  context.lineWidth = Math.max(1, 0.025 * perMetre);
  context.beginPath();
  const step = TILE * perMetre;
  for (let x = step; x < width; x += step) context.rect(x, 0, 0, height);
  for (let y = height - step; y > 0; y -= step) context.rect(0, y, width, 0);
  context.stroke();
  context.globalAlpha = 1;
}

/** Soft shadows, by drawing what stands there small and enlarging it. */
function shaded(context: CanvasRenderingContext2D, pixels: ImageData, resolution: number, colours: Colours): void {
  const [r, g, b] = rgbOf(colours.free);
  if (r + g + b < 30) return; // on black no shadow is seen
  const mask = document.createElement("canvas");
  mask.width = pixels.width;
  mask.height = pixels.height;
  const dark = new ImageData(pixels.width, pixels.height);
  for (let k = 0; k < dark.data.length; k += 4) dark.data[k + 3] = pixels.data[k]! < 64 ? 255 : 0;
  mask.getContext("2d")!.putImageData(dark, 0, 0);
  const small = document.createElement("canvas");
  const cells = Math.max(1, SHADOW / resolution / 1.5);
  small.width = Math.max(1, Math.round(pixels.width / cells));
  small.height = Math.max(1, Math.round(pixels.height / cells));
  const shrunk = small.getContext("2d")!;
  shrunk.imageSmoothingQuality = "high";
  shrunk.drawImage(mask, 0, 0, small.width, small.height);
  context.globalAlpha = SHADOW_STRENGTH;
  context.drawImage(small, 0, 0, context.canvas.width, context.canvas.height);
  context.globalAlpha = 1;
}

/** No side longer than the graphics card takes. */
function fitting(picture: HTMLCanvasElement, most: number): HTMLCanvasElement {
  const share = most / Math.max(picture.width, picture.height);
  if (share >= 1) return picture;
  const less = document.createElement("canvas");
  less.width = Math.floor(picture.width * share);
  less.height = Math.floor(picture.height * share);
  less.getContext("2d")!.drawImage(picture, 0, 0, less.width, less.height);
  return less;
}
