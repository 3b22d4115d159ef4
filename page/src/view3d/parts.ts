// Rounded parts put together to figures: z up, each part with a colour of its own.

import {
  BoxGeometry,
  BufferGeometry,
  CapsuleGeometry,
  Color,
  CylinderGeometry,
  Float32BufferAttribute,
  Matrix4,
  Mesh,
  Object3D,
  Quaternion,
  SphereGeometry,
  Vector3,
  type InstancedMesh,
  type Material,
  type Texture,
} from "three";
import { RoundedBoxGeometry } from "three/examples/jsm/geometries/RoundedBoxGeometry.js";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Vector } from "./cameras";

const Y = new Vector3(0, 1, 0);

/** A cylinder between two points, with round ends. */
export function limb(from: Vector, to: Vector, radius: number, colour: Color, segments = 10): BufferGeometry {
  return along(new CapsuleGeometry(radius, span(from, to), 3, segments), from, to, colour);
}

/** A cylinder between two points, with flat ends. */
export function rod(from: Vector, to: Vector, radius: number, colour: Color, segments = 12): BufferGeometry {
  return along(new CylinderGeometry(radius, radius, span(from, to), segments), from, to, colour);
}

export function ball(at: Vector, radius: number, colour: Color, stretch: Vector = [1, 1, 1]): BufferGeometry {
  const made = new SphereGeometry(radius, 14, 10).scale(...stretch).translate(...at);
  return coloured(made, colour);
}

/** A box with rounded edges about a point; `tilt` turns it about y (left), rad. */
export function block(at: Vector, size: Vector, colour: Color, round = 0.02, tilt = 0): BufferGeometry {
  const [x, y, z] = size;
  const made = round > 0 ? new RoundedBoxGeometry(x, y, z, 2, round) : new BoxGeometry(x, y, z);
  return coloured(made.rotateY(tilt).translate(...at), colour);
}

export function coloured(geometry: BufferGeometry, colour: Color): BufferGeometry {
  const count = geometry.getAttribute("position").count;
  const colours = Array.from({ length: count }, () => [colour.r, colour.g, colour.b]).flat();
  geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
  geometry.deleteAttribute("uv");
  return geometry.index ? geometry : indexed(geometry);
}

/** One geometry of several; they are used up. */
export function joined(parts: readonly BufferGeometry[]): BufferGeometry {
  const whole = mergeGeometries([...parts]);
  parts.forEach((part) => part.dispose());
  return whole;
}

/** Frees what the graphics card holds of a tree of objects. */
export function release(root: Object3D): void {
  root.traverse((each) => {
    if (!(each instanceof Object3D)) return;
    const { geometry, material } = each as Partial<Mesh>;
    geometry?.dispose();
    for (const one of [material ?? []].flat() as (Material & { map?: Texture | null })[]) {
      one.map?.dispose();
      one.dispose();
    }
    if ("isInstancedMesh" in each) (each as InstancedMesh).dispose();
  });
  root.clear();
}

function along(made: BufferGeometry, from: Vector, to: Vector, colour: Color): BufferGeometry {
  const [a, b] = [new Vector3(...from), new Vector3(...to)];
  const turn = new Quaternion().setFromUnitVectors(Y, b.clone().sub(a).normalize());
  const placed = new Matrix4().compose(a.add(b).multiplyScalar(0.5), turn, new Vector3(1, 1, 1));
  return coloured(made.applyMatrix4(placed), colour);
}

function span(from: Vector, to: Vector): number {
  return Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

function indexed(geometry: BufferGeometry): BufferGeometry {
  const count = geometry.getAttribute("position").count;
  geometry.setIndex(Array.from({ length: count }, (_, k) => k));
  return geometry;
}
