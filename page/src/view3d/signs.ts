// Names of places, upright before the camera; those that would lie on each other are left out.

import { CanvasTexture, Group, SRGBColorSpace, Sprite, SpriteMaterial, Vector3, type PerspectiveCamera } from "three";
import { placed, type Label } from "../map/labels";
import type { Colours } from "../map/palette";
import type { PlaceInfo } from "../messages";

const FONT = "600 26px system-ui, sans-serif";
const HEIGHT = 40;
const EDGE = 8;
/** On the screen, px. */
const SHOWN = 20;
/** Above the floor, m: above the head of a person. */
const Z = 1.9;
/** Names farther from the camera are not read, m (assumed). */
const FAR = 21;
/** Near ones would cover the view, m (assumed). */
const NEAR = 2.5;

export class Signs {
  readonly group = new Group();
  readonly #signs: { sprite: Sprite; width: number; name: string }[] = [];

  constructor(places: readonly PlaceInfo[], colours: Colours) {
    for (const { name, x, y } of places) {
      const { texture, width } = written(name, colours);
      const material = new SpriteMaterial({ map: texture, sizeAttenuation: false, depthTest: false, depthWrite: false });
      const sprite = new Sprite(material);
      sprite.position.set(x, y, Z);
      sprite.renderOrder = 20;
      this.group.add(sprite);
      this.#signs.push({ sprite, width, name });
    }
  }

  /** Chooses what is shown on a screen of this size, px. */
  arrange(camera: PerspectiveCamera, width: number, height: number): void {
    const unit = (2 * Math.tan((camera.fov * Math.PI) / 360)) / height;
    const labels: (Label & { sprite: Sprite })[] = [];
    for (const { sprite, width: wide, name } of this.#signs) {
      sprite.visible = false;
      const far = sprite.position.distanceTo(camera.position);
      if (far > FAR || far < NEAR) continue;
      const at = new Vector3().copy(sprite.position).project(camera);
      if (at.z > 1 || Math.abs(at.x) > 1 || Math.abs(at.y) > 1) continue;
      const size = (wide * SHOWN) / HEIGHT;
      sprite.scale.set(size * unit, SHOWN * unit, 1);
      const [x, y] = [((at.x + 1) * width) / 2, ((1 - at.y) * height) / 2];
      labels.push({ name, x, y, width: size, height: SHOWN, sprite });
    }
    const distance = ({ sprite }: { sprite: Sprite }): number => sprite.position.distanceTo(camera.position);
    labels.sort((a, b) => distance(a) - distance(b));
    // A sign stays on its place: one that would have to be moved aside is left out.
    for (const { label, x, y } of placed(labels)) {
      const { sprite, x: px, y: py } = label as (typeof labels)[number];
      sprite.visible = x === px && y === py;
    }
  }
}

function written(name: string, colours: Colours): { texture: CanvasTexture; width: number } {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  context.font = FONT;
  canvas.width = Math.ceil(context.measureText(name).width) + 2 * EDGE;
  canvas.height = HEIGHT;
  context.font = FONT;
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = 7;
  context.strokeStyle = colours.free;
  context.fillStyle = colours.text;
  context.strokeText(name, EDGE, HEIGHT / 2);
  context.fillText(name, EDGE, HEIGHT / 2);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return { texture, width: canvas.width };
}
