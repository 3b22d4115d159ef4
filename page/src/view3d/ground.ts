// The floor: the map's picture on a plane, darker where walls and furniture keep the light away.

import {
  BufferGeometry,
  CanvasTexture,
  Float32BufferAttribute,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  SRGBColorSpace,
} from "three";
import { tinted } from "../map/floor";
import { rgbOf, type Colours } from "../map/palette";
import type { FloorInfo } from "../messages";

/** Reach of the soft shadow beside a wall (assumed), m. */
const SHADOW = 0.45;
const SHADOW_STRENGTH = 0.34;

/** Grey pixels of the map's picture. */
export function pixelsOf(image: HTMLImageElement): ImageData {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

export function ground(image: HTMLImageElement, pixels: ImageData, floor: FloorInfo, colours: Colours, most: number): Mesh {
  const texture = new CanvasTexture(fitting(shaded(tinted(image, colours), pixels, floor, colours), most));
  texture.colorSpace = SRGBColorSpace;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.anisotropy = 2;
  const { x, y, width, height, resolution } = floor;
  const [right, top] = [x + width * resolution, y + height * resolution];
  const made = new BufferGeometry();
  const corners = [x, y, 0, right, y, 0, right, top, 0, x, top, 0];
  made.setAttribute("position", new Float32BufferAttribute(corners, 3));
  made.setAttribute("uv", new Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 1], 2));
  made.setIndex([0, 1, 2, 0, 2, 3]);
  return new Mesh(made, new MeshBasicMaterial({ map: texture }));
}

/** Soft shadows by drawing what stands there small and enlarging it. */
function shaded(picture: HTMLCanvasElement, pixels: ImageData, floor: FloorInfo, colours: Colours): HTMLCanvasElement {
  const [r, g, b] = rgbOf(colours.free);
  if (r + g + b < 30) return picture; // on black no shadow is seen
  const mask = document.createElement("canvas");
  mask.width = pixels.width;
  mask.height = pixels.height;
  const dark = new ImageData(pixels.width, pixels.height);
  for (let k = 0; k < dark.data.length; k += 4) dark.data[k + 3] = pixels.data[k]! < 64 ? 255 : 0;
  mask.getContext("2d")!.putImageData(dark, 0, 0);
  const small = document.createElement("canvas");
  const cells = Math.max(1, SHADOW / floor.resolution / 1.5);
  small.width = Math.max(1, Math.round(pixels.width / cells));
  small.height = Math.max(1, Math.round(pixels.height / cells));
  const shrunk = small.getContext("2d")!;
  shrunk.imageSmoothingQuality = "high";
  shrunk.drawImage(mask, 0, 0, small.width, small.height);
  const context = picture.getContext("2d")!;
  context.globalAlpha = SHADOW_STRENGTH;
  context.imageSmoothingQuality = "high";
  context.drawImage(small, 0, 0, picture.width, picture.height);
  context.globalAlpha = 1;
  return picture;
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
