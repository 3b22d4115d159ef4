// Flat signs on the floor.

import {
  BufferGeometry,
  CanvasTexture,
  CircleGeometry,
  Float32BufferAttribute,
  MeshBasicMaterial,
  RingGeometry,
} from "three";
import type { Strip } from "./ribbon";

const DASHES = 10;

export function geometryOf({ positions, indices }: Strip): BufferGeometry {
  const made = new BufferGeometry();
  made.setAttribute("position", new Float32BufferAttribute(positions, 3));
  made.setIndex([...indices]);
  return made;
}

/** Half a disc of radius 1 ahead (1) or behind (−1). */
export function halfDisc(side: 1 | -1): BufferGeometry {
  return new CircleGeometry(1, 20, side > 0 ? -Math.PI / 2 : Math.PI / 2, Math.PI);
}

export function halfRing(side: 1 | -1): BufferGeometry {
  return new RingGeometry(0.97, 1, 24, 1, side > 0 ? -Math.PI / 2 : Math.PI / 2, Math.PI);
}

/** Dashes about a circle of radius 1. */
export function dashedRing(): BufferGeometry {
  const positions: number[] = [];
  const indices: number[] = [];
  for (let k = 0; k < DASHES; k++) {
    const first = positions.length / 3;
    for (let part = 0; part <= 3; part++) {
      const angle = (2 * Math.PI * (k + (0.6 * part) / 3)) / DASHES;
      for (const r of [0.9, 1.06]) positions.push(r * Math.cos(angle), r * Math.sin(angle), 0);
    }
    for (let part = 0; part < 3; part++) {
      const at = first + 2 * part;
      indices.push(at, at + 1, at + 2, at + 1, at + 3, at + 2);
    }
  }
  return geometryOf({ positions, indices });
}

/** Arrowhead along x. */
export function arrow(from: number, to: number, half: number): BufferGeometry {
  return geometryOf({ positions: [from, half, 0, from, -half, 0, to, 0, 0], indices: [0, 1, 2] });
}

/** Soft dark disc below what stands on the floor. */
export function shadow(): MeshBasicMaterial {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const context = canvas.getContext("2d");
  const fade = context?.createRadialGradient(32, 32, 0, 32, 32, 32);
  if (context && fade) {
    fade.addColorStop(0, "rgba(0, 0, 0, 0.5)");
    fade.addColorStop(0.45, "rgba(0, 0, 0, 0.3)");
    fade.addColorStop(1, "rgba(0, 0, 0, 0)");
    context.fillStyle = fade;
    context.fillRect(0, 0, 64, 64);
  }
  return new MeshBasicMaterial({ map: new CanvasTexture(canvas), transparent: true, depthWrite: false });
}
