// People: figures with a heading for whom the chair tracks, pale ones for whom it does not.

import {
  CircleGeometry,
  Color,
  DynamicDrawUsage,
  Group,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Quaternion,
  Vector3,
  type BufferGeometry,
  type Material,
} from "three";
import { unseen } from "../map/figures";
import type { Shown } from "../map/motion";
import type { Colours } from "../map/palette";
import type { PersonInfo } from "../messages";
import { ball, block, joined, limb, rod } from "./parts";
import { arrow, dashedRing, halfDisc, halfRing, shadow } from "./flat";

/** So many figures fit at first; the room doubles where it does not do. */
const ROOM = 16;
/** Slower people stand: they face along their space's axis, m/s (as on the map). */
const STANDS = 0.15;
/** Two steps of a walking person (assumed), m. */
const STRIDE = 1.35;
const SWING = 0.5;
const HIP = 0.86;
const UP = new Vector3(0, 0, 1);
const LEFT = new Vector3(0, 1, 0);
/** Width of the model's shoulders as a radius; a person's own radius scales it, m. */
const RADIUS = 0.25;
/** Flat signs lie at these heights, m, so that none shines through another. */
const SPACE_Z = 0.008;
const SIGN_Z = 0.014;

interface Kind {
  readonly geometry: BufferGeometry;
  readonly material: Material;
  readonly order: number;
}

interface Crowd {
  readonly mesh: InstancedMesh;
  count: number;
}

export class People {
  readonly group = new Group();
  readonly #crowds = new Map<string, Crowd>();
  readonly #kinds: Readonly<Record<string, Kind>>;
  readonly #walked = new Map<number, { x: number; y: number; phase: number }>();

  constructor(colours: Colours) {
    this.#kinds = kinds(colours);
  }

  /** Draws everybody; without `moves` nobody swings their legs. */
  show(shown: Shown, moves: boolean): void {
    for (const crowd of this.#crowds.values()) crowd.count = 0;
    const there = new Set(shown.people.map(({ id }) => id));
    for (const id of this.#walked.keys()) if (!there.has(id)) this.#walked.delete(id);
    for (const person of shown.people) this.#person(person, moves);
    for (const [x, y, radius] of unseen(shown)) {
      this.#put("pale", at(x, y, 0, 0, girth(radius)));
      this.#put("ring", at(x, y, SIGN_Z, 0, new Vector3(radius, radius, 1)));
    }
    for (const { mesh, count } of this.#crowds.values()) {
      mesh.count = count;
      mesh.visible = count > 0;
      mesh.instanceMatrix.needsUpdate = true;
    }
  }

  #person(person: PersonInfo, moves: boolean): void {
    const { x, y, radius } = person;
    const heading = headingOf(person);
    const wide = girth(radius);
    this.#put("body", at(x, y, 0, heading, wide));
    const swing = moves ? SWING * Math.sin(this.#phase(person)) : 0;
    for (const side of [1, -1]) this.#put("leg", legAt(x, y, heading, wide, side, side * swing));
    this.#put("shadow", at(x, y, 0.004, 0, new Vector3(0.42, 0.42, 1)));
    if (Math.hypot(person.vx, person.vy) >= STANDS) this.#put("arrow", at(x, y, SIGN_Z, heading, new Vector3(1, 1, 1)));
    const { axis, front, side, rear } = person;
    for (const [kind, along] of [["Front", front], ["Rear", rear]] as const) {
      const size = new Vector3(along, side, 1);
      this.#put(`space${kind}`, at(x, y, SPACE_Z, axis, size));
      this.#put(`edge${kind}`, at(x, y, SPACE_Z + 0.002, axis, size));
    }
  }

  /** Grows with the way that was walked. */
  #phase({ id, x, y }: PersonInfo): number {
    const was = this.#walked.get(id) ?? { x, y, phase: id };
    const phase = was.phase + (2 * Math.PI * Math.hypot(x - was.x, y - was.y)) / STRIDE;
    this.#walked.set(id, { x, y, phase });
    return phase;
  }

  #put(kind: string, where: Matrix4): void {
    let crowd = this.#crowds.get(kind);
    if (!crowd || crowd.count === crowd.mesh.instanceMatrix.count) crowd = this.#grown(kind, crowd);
    crowd.mesh.setMatrixAt(crowd.count++, where);
  }

  #grown(kind: string, was: Crowd | undefined): Crowd {
    const { geometry, material, order } = this.#kinds[kind]!;
    const mesh = new InstancedMesh(geometry, material, was ? 2 * was.mesh.instanceMatrix.count : ROOM);
    mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    mesh.frustumCulled = false; // its bounds are those of one figure
    mesh.renderOrder = order;
    if (was) {
      mesh.instanceMatrix.array.set(was.mesh.instanceMatrix.array);
      this.group.remove(was.mesh);
      was.mesh.dispose();
    }
    this.group.add(mesh);
    const crowd = { mesh, count: was?.count ?? 0 };
    this.#crowds.set(kind, crowd);
    return crowd;
  }
}

/** Direction in which a person looks, rad: that of walking, for who stands the space's axis. */
export function headingOf({ vx, vy, axis }: Pick<PersonInfo, "vx" | "vy" | "axis">): number {
  return Math.hypot(vx, vy) < STANDS ? axis : Math.atan2(vy, vx);
}

function girth(radius: number): Vector3 {
  const wide = Math.min(1.25, Math.max(0.8, radius / RADIUS));
  return new Vector3(wide, wide, 1);
}

function at(x: number, y: number, z: number, heading: number, size: Vector3): Matrix4 {
  const turn = new Quaternion().setFromAxisAngle(UP, heading);
  return new Matrix4().compose(new Vector3(x, y, z), turn, size);
}

/** A leg hangs from its hip and swings forward by an angle, rad. */
function legAt(x: number, y: number, heading: number, wide: Vector3, side: number, swing: number): Matrix4 {
  const hip = new Matrix4().compose(
    new Vector3(0, side * 0.085, HIP),
    new Quaternion().setFromAxisAngle(LEFT, -swing),
    new Vector3(1, 1, 1),
  );
  return at(x, y, 0, heading, wide).multiply(hip);
}

function kinds(colours: Colours): Readonly<Record<string, Kind>> {
  const cloth = new Color(colours.person);
  const hair = new Color("#4a3524");
  const trousers = new Color("#3e4f63");
  const skin = new Color("#d9b597");
  const lit = new MeshLambertMaterial({ vertexColors: true });
  const pale = new MeshLambertMaterial({ color: cloth, transparent: true, opacity: 0.28, depthWrite: false });
  const flat = (colour: string, opacity: number): MeshBasicMaterial =>
    new MeshBasicMaterial({ color: colour, transparent: opacity < 1, opacity, depthWrite: false });
  const fill = flat(colours.space, 0.2);
  const edge = flat(colours.space, 0.6);
  const own = (geometry: BufferGeometry, material: Material, order = 0): Kind => ({ geometry, material, order });
  return {
    body: own(body(cloth, trousers, { hair, skin }), lit),
    leg: own(leg(trousers), lit),
    pale: own(ghost(cloth), pale, 5),
    ring: own(dashedRing(), flat(colours.person, 0.9), 3),
    arrow: own(arrow(0.34, 0.58, 0.17), flat(colours.person, 1), 3),
    shadow: own(new CircleGeometry(1, 20), shadow(), 1),
    spaceFront: own(halfDisc(1), fill, 2),
    spaceRear: own(halfDisc(-1), fill, 2),
    edgeFront: own(halfRing(1), edge, 2),
    edgeRear: own(halfRing(-1), edge, 2),
  };
}

/** A person of 1.72 m without legs, looking along x. */
function body(cloth: Color, trousers: Color, { hair, skin }: { hair: Color; skin: Color }): BufferGeometry {
  const arms = [1, -1].flatMap((side) => [
    limb([0, side * 0.205, 1.36], [-0.01, side * 0.235, 1.1], 0.045, cloth, 8),
    limb([-0.01, side * 0.235, 1.1], [0.06, side * 0.225, 0.88], 0.036, cloth, 8),
    ball([0.07, side * 0.225, 0.83], 0.04, skin),
  ]);
  return joined([
    limb([0, 0, 0.98], [0, 0, 1.25], 0.135, cloth, 12),
    limb([0, 0.12, 1.37], [0, -0.12, 1.37], 0.085, cloth, 10),
    block([0, 0, 0.89], [0.21, 0.28, 0.16], trousers, 0.06),
    rod([0, 0, 1.38], [0.01, 0, 1.52], 0.048, skin, 10),
    ball([0.02, 0, 1.6], 0.1, skin, [1, 0.85, 1.18]),
    ball([-0.012, 0, 1.628], 0.103, hair, [1, 0.9, 1.08]),
    ball([0.118, 0, 1.59], 0.018, skin), // nose
    ...arms,
  ]);
}

/** From the hip down. */
function leg(colour: Color): BufferGeometry {
  return joined([
    limb([0, 0, -0.06], [0, 0, -0.72], 0.068, colour, 10),
    block([0.05, 0, -0.825], [0.24, 0.09, 0.07], colour.clone().multiplyScalar(0.7), 0.03),
  ]);
}

function ghost(colour: Color): BufferGeometry {
  return joined([limb([0, 0, 0.2], [0, 0, 1.25], 0.2, colour, 14), ball([0, 0, 1.6], 0.11, colour)]);
}
