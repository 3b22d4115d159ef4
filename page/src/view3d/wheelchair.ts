// The chair with its rider, in the base frame: x forward, y left, z up, origin below the drive axle.

import { CircleGeometry, Color, Group, Mesh, MeshLambertMaterial, type BufferGeometry } from "three";
import type { Colours } from "../map/palette";
import type { ChairInfo } from "../messages";
import type { Pose } from "./cameras";
import { shadow } from "./flat";
import { ball, block, joined, limb, rod } from "./parts";

/** The model's own outline, to which a chair's outline is fitted: a mid-wheel chair, m. */
const MODEL = { front: 0.65, rear: -0.46, half: 0.305 } as const;
/** What is shorter carries nobody (assumed), m. */
const SHORTEST_WITH_SEAT = 0.75;
const DRIVE_RADIUS = 0.178;
const CASTER_RADIUS = 0.075;
/** Distance of a caster's axle from its swivel (assumed), m. */
const TRAIL = 0.05;
const CASTERS = [[0.33, 0.215], [0.33, -0.215], [-0.34, 0.2], [-0.34, -0.2]] as const;
/** Slower than this a caster keeps its direction, m/s. */
const SWIVELS = 0.03;

export interface ChairModel {
  readonly group: Group;
  /** The rider's head and trunk, which rider's eyes do not see. */
  readonly rider: Mesh | null;
  /** At a pose, with wheels as the twist (m/s, rad/s) of the last `seconds` leaves them. */
  place(pose: Pose, twist: readonly [number, number], seconds: number): void;
}

interface Tints {
  readonly body: Color;
  readonly dark: Color;
  readonly metal: Color;
  readonly seat: Color;
  readonly cloth: Color;
  readonly trousers: Color;
  readonly skin: Color;
  readonly mark: Color;
  readonly hair: Color;
}

export function chairModel(chair: Pick<ChairInfo, "outline">, colours: Colours): ChairModel {
  const extent = extentOf(chair.outline);
  const tints = tintsOf(colours);
  const group = new Group();
  const long = extent.front - extent.rear;
  if (long < SHORTEST_WITH_SEAT) {
    group.add(mesh(carrier(extent, tints)));
    return { group, rider: null, place: (pose) => put(group, pose) };
  }
  const shade = new Mesh(new CircleGeometry(1, 24), shadow());
  shade.scale.set(0.62 * long, 1.5 * extent.half, 1);
  shade.position.set((extent.front + extent.rear) / 2, 0, 0.005);
  shade.renderOrder = 1;
  group.add(shade);
  const fitted = new Group();
  fitted.scale.set(long / (MODEL.front - MODEL.rear), extent.half / MODEL.half, 1);
  fitted.position.x = extent.front - MODEL.front * fitted.scale.x;
  group.add(fitted);
  const rider = mesh(upperBody(tints));
  const wheels = [1, -1].map((side) => wheel(side * (MODEL.half - 0.045), tints));
  const casters = CASTERS.map(([x, y]) => caster(x, y, tints));
  fitted.add(mesh(frame(tints)), mesh(lowerBody(tints)), rider, ...wheels, ...casters);
  return {
    group,
    rider,
    place(pose, twist, seconds) {
      put(group, pose);
      for (const each of wheels) {
        const speed = twist[0] - twist[1] * each.position.y;
        each.rotation.y += (speed * seconds) / DRIVE_RADIUS;
      }
      for (const each of casters) swivel(each, twist, seconds);
    },
  };
}

/** Extent of an outline in the base frame, m. */
export function extentOf(outline: ChairInfo["outline"]): { front: number; rear: number; half: number } {
  return {
    front: Math.max(...outline.map(([x]) => x)),
    rear: Math.min(...outline.map(([x]) => x)),
    half: Math.max(...outline.map(([, y]) => Math.abs(y))),
  };
}

function put(group: Group, [x, y, heading]: Pose): void {
  group.position.set(x, y, 0);
  group.rotation.z = heading;
}

/** A caster trails behind the velocity of its swivel; it comes round within its trail. */
function swivel(one: Group, [forward, turn]: readonly [number, number], seconds: number): void {
  const vx = forward - turn * one.position.y;
  const vy = turn * one.position.x;
  const speed = Math.hypot(vx, vy);
  if (speed < SWIVELS) return;
  const off = Math.atan2(vy, vx) - one.rotation.z;
  const share = Math.min(1, (speed * seconds) / TRAIL);
  one.rotation.z += share * Math.atan2(Math.sin(off), Math.cos(off));
}

function tintsOf(colours: Colours): Tints {
  const body = new Color(colours.chair);
  const free = new Color(colours.free);
  const dark = new Color("#1d242b");
  return {
    body,
    dark,
    metal: new Color("#9aa7b3"),
    seat: dark.clone().lerp(body, 0.25),
    cloth: new Color(colours.wish).lerp(free.r + free.g + free.b > 1.5 ? free : new Color("#ffffff"), 0.18),
    trousers: new Color("#3e4f63"),
    skin: new Color("#d9b597"),
    mark: new Color(colours.accent),
    hair: new Color("#4a3524"),
  };
}

function frame({ body, dark, metal, seat, mark }: Tints): BufferGeometry {
  const sides = [1, -1].flatMap((side) => [
    block([0.02, side * 0.262, 0.735], [0.34, 0.062, 0.045], dark, 0.02), // armrests
    rod([-0.12, side * 0.262, 0.5], [-0.12, side * 0.262, 0.73], 0.014, metal, 8),
    block([0.0, side * 0.262, 0.2], [0.3, 0.05, 0.1], body, 0.02), // mudguards
    rod([0.2, side * 0.13, 0.47], [0.5, side * 0.12, 0.13], 0.017, metal, 8), // leg rests
    block([0.545, side * 0.105, 0.115], [0.2, 0.15, 0.02], dark, 0.008, -0.14), // footplates
  ]);
  return joined([
    block([-0.02, 0, 0.25], [0.7, 0.4, 0.2], body, 0.06),
    block([-0.28, 0, 0.36], [0.2, 0.36, 0.1], dark, 0.04), // batteries
    rod([0, 0, 0.3], [0, 0, 0.47], 0.06, metal),
    block([0.0, 0, 0.505], [0.48, 0.46, 0.085], seat, 0.035),
    block([-0.275, 0, 0.82], [0.075, 0.44, 0.56], seat, 0.035, -0.13),
    block([-0.335, 0, 1.185], [0.06, 0.25, 0.14], seat, 0.028, -0.13),
    rod([-0.315, 0, 1.06], [-0.33, 0, 1.16], 0.014, metal, 8),
    ...sides,
    block([0.2, -0.262, 0.765], [0.1, 0.07, 0.05], dark, 0.02), // joystick
    rod([0.2, -0.262, 0.78], [0.205, -0.262, 0.84], 0.009, dark, 8),
    ball([0.206, -0.262, 0.848], 0.02, mark),
  ]);
}

/** Head, trunk and arms: the right hand at the joystick. */
function upperBody({ cloth, skin, hair }: Tints): BufferGeometry {
  const arms = [1, -1].flatMap((side) => [
    limb([-0.11, side * 0.2, 0.98], [-0.06, side * 0.265, 0.8], 0.047, cloth),
    limb([-0.06, side * 0.265, 0.8], [side > 0 ? 0.14 : 0.16, side * 0.262, 0.795], 0.037, cloth),
    ball([side > 0 ? 0.17 : 0.195, side * 0.262, 0.815], 0.042, skin),
  ]);
  return joined([
    limb([-0.08, 0, 0.66], [-0.1, 0, 0.92], 0.135, cloth, 14),
    limb([-0.115, 0.09, 0.985], [-0.115, -0.09, 0.985], 0.085, cloth, 12),
    rod([-0.11, 0, 1.0], [-0.1, 0, 1.12], 0.05, skin),
    ball([-0.08, 0, 1.2], 0.1, skin, [1, 0.86, 1.14]),
    ball([-0.108, 0, 1.228], 0.103, hair, [1, 0.9, 1.08]),
    ball([0.022, 0, 1.19], 0.017, skin), // nose
    ...arms,
  ]);
}

function lowerBody({ trousers, dark }: Tints): BufferGeometry {
  return joined(
    [1, -1].flatMap((side) => [
      limb([-0.12, side * 0.09, 0.61], [0.27, side * 0.1, 0.6], 0.078, trousers, 12),
      limb([0.28, side * 0.1, 0.59], [0.45, side * 0.105, 0.22], 0.056, trousers, 12),
      block([0.53, side * 0.105, 0.155], [0.2, 0.085, 0.07], dark, 0.03, -0.14),
    ]),
  );
}

/** A drive wheel about the origin, spokes and all, so that one sees it turn. */
function wheel(y: number, { dark, metal, body }: Tints): Mesh {
  const spokes = Array.from({ length: 5 }, (_, k) => {
    const angle = (2 * Math.PI * k) / 5;
    const end = [0.118 * Math.cos(angle), 0, 0.118 * Math.sin(angle)] as const;
    return rod([0, 0, 0], end, 0.017, metal, 6);
  });
  const [inner, outer] = [[0, -0.03, 0], [0, 0.03, 0]] as const;
  const rim = [rod([0, -0.036, 0], [0, 0.036, 0], DRIVE_RADIUS, dark, 28), rod([0, -0.038, 0], [0, 0.038, 0], 0.125, body, 20)];
  const hubs = [rod([0, -0.045, 0], [0, 0.045, 0], 0.04, metal, 14)];
  const faces = spokes.flatMap((spoke) => [spoke.clone().translate(...outer), spoke.translate(...inner)]);
  const made = mesh(joined([...rim, ...hubs, ...faces]));
  made.position.set(0, y, DRIVE_RADIUS);
  return made;
}

/** A caster about its swivel. */
function caster(x: number, y: number, { dark, metal }: Tints): Group {
  const r = CASTER_RADIUS;
  const made = new Group();
  made.position.set(x, y, 0);
  made.add(
    mesh(
      joined([
        rod([-TRAIL, -0.022, r], [-TRAIL, 0.022, r], r, dark, 18),
        rod([-TRAIL, -0.025, r], [-TRAIL, 0.025, r], 0.03, metal, 10),
        limb([0, 0, 0.2], [-TRAIL, 0, r + 0.08], 0.022, metal, 8),
      ]),
    ),
  );
  return made;
}

/** A low robot without a seat. */
function carrier({ front, rear, half }: ReturnType<typeof extentOf>, { body, dark }: Tints): BufferGeometry {
  const middle = (front + rear) / 2;
  const tyre = 0.1;
  const tyres = [front - 1.4 * tyre, rear + 1.4 * tyre].flatMap((x) =>
    [1, -1].map((side) => rod([x, side * (half - 0.08), tyre], [x, side * half, tyre], tyre, dark, 20)),
  );
  return joined([block([middle, 0, 0.2], [front - rear, 2 * half - 0.17, 0.16], body, 0.04), ...tyres]);
}

function mesh(geometry: BufferGeometry): Mesh {
  return new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true }));
}
