import { Group, PerspectiveCamera, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { CAMERAS, EYE_HEIGHT, followed, headsetAxes, sightOf, zoomedBy, type Pose, type Sight } from "./cameras";
import { sit } from "./headset";

function camera(sight: Sight): PerspectiveCamera {
  const made = new PerspectiveCamera(sight.angle, 1, 0.1, 100);
  made.up.set(...sight.up);
  made.position.set(...sight.at);
  made.lookAt(...sight.look);
  made.updateMatrixWorld();
  return made;
}

/** On the screen: right and up, −1 to 1. */
function seen(sight: Sight, x: number, y: number, z: number): Vector3 {
  return new Vector3(x, y, z).project(camera(sight));
}

const POSES: Pose[] = [[0, 0, 0], [3, -2, 1.2], [-5, 4, -2.5]];

describe("cameras in the map's frame", () => {
  it.each(POSES)("from behind and from the eyes: left is left, ahead is farther, up is up (%s, %s, %s)", (x, y, heading) => {
    const [c, s] = [Math.cos(heading), Math.sin(heading)];
    for (const name of ["behind", "eyes"] as const) {
      const sight = sightOf(name, [x, y, heading]);
      const ahead = seen(sight, x + 4 * c, y + 4 * s, 1);
      expect(Math.abs(ahead.x)).toBeLessThan(1e-6);
      expect(seen(sight, x + 4 * c - s, y + 4 * s + c, 1).x).toBeLessThan(ahead.x - 0.05); // 1 m to the left
      expect(seen(sight, x + 4 * c, y + 4 * s, 1.5).y).toBeGreaterThan(ahead.y);
      expect(seen(sight, x + 8 * c, y + 8 * s, 1).z).toBeGreaterThan(ahead.z);
    }
  });

  it("from above: north up, as on the map, however the chair stands", () => {
    for (const heading of [0, 1, 3]) {
      const sight = sightOf("above", [1, 1, heading]);
      const chair = seen(sight, 1, 1, 0);
      expect(seen(sight, 1, 3, 0).y).toBeGreaterThan(chair.y);
      expect(seen(sight, 3, 1, 0).x).toBeGreaterThan(chair.x);
    }
  });

  it("see the chair in the picture, from behind and from above, at every zoom", () => {
    for (const name of ["behind", "above"] as const) {
      for (const zoom of [0.45, 1, 3.2]) {
        const at = seen(sightOf(name, [2, 3, 0.7], zoom), 2, 3, 0.5);
        expect(Math.max(Math.abs(at.x), Math.abs(at.y))).toBeLessThan(1);
      }
    }
  });

  it("cut the walls for all but the rider's eyes", () => {
    expect(CAMERAS.map((name) => sightOf(name, [0, 0, 0]).cut === null)).toEqual([false, false, true]);
  });
});

describe("a camera that follows", () => {
  const from = sightOf("behind", [0, 0, 0]);
  const to = sightOf("behind", [1, 0, 0]);

  it("comes nearer by the same share in equal times", () => {
    const once = followed(from, to, 0.2);
    const twice = followed(followed(from, to, 0.1), to, 0.1);
    expect(once.at[0]).toBeCloseTo(twice.at[0]);
    expect(once.at[0]).toBeGreaterThan(from.at[0]);
    expect(once.at[0]).toBeLessThan(to.at[0]);
  });

  it("is there at once for another kind of camera, and for the eyes", () => {
    const eyes = sightOf("eyes", [1, 0, 0]);
    expect(followed(from, eyes, 0.01)).toBe(eyes);
    expect(followed(null, to, 0.01)).toBe(to);
  });

  it("stays within its zoom", () => {
    expect(zoomedBy(3, 4)).toBe(3.2);
    expect(zoomedBy(0.5, 0.1)).toBe(0.45);
  });
});

describe("a headset", () => {
  it.each(POSES)("looks along the chair's heading, from the rider's eyes (%s, %s, %s)", (x, y, heading) => {
    const rig = new Group();
    const eye = new PerspectiveCamera();
    rig.add(eye);
    sit(rig, [x, y, heading]);
    rig.updateMatrixWorld(true);
    const direction = eye.getWorldDirection(new Vector3());
    expect(direction.x).toBeCloseTo(Math.cos(heading));
    expect(direction.y).toBeCloseTo(Math.sin(heading));
    expect(eye.getWorldPosition(new Vector3()).toArray()).toEqual([x, y, EYE_HEIGHT]);
  });

  it("has axes of a right-handed frame", () => {
    const [right, up, back] = headsetAxes(0.8).map((axis) => new Vector3(...axis)) as [Vector3, Vector3, Vector3];
    expect(right.clone().cross(up).distanceTo(back)).toBeCloseTo(0);
  });
});
