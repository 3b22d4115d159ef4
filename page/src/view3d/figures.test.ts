import { Box3, InstancedMesh, Matrix4, Vector3, type Object3D } from "three";
import { describe, expect, it, vi } from "vitest";
import type { Shown } from "../map/motion";
import type { Colours } from "../map/palette";
import type { ChairInfo, PersonInfo } from "../messages";
import { Detail } from "./detail";
import { release } from "./parts";
import { headingOf, People } from "./people";
import { chairModel } from "./wheelchair";
import { direction, inWords } from "./words";

// jsdom has no canvas: shadows stay without their picture.
vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(null);

const COLOURS = new Proxy({}, { get: () => "#808080" }) as Colours;
const CHAIR: ChairInfo = {
  name: "quantum_q6_edge",
  outline: [[0.65, 0.305], [-0.46, 0.305], [-0.46, -0.305], [0.65, -0.305]],
  max_speed: 1,
  max_acceleration: 1,
  max_turn_rate: 1,
  sees_floor: false,
};

const person = (more: Partial<PersonInfo> = {}): PersonInfo => ({
  id: 1, x: 2, y: 1, vx: 0, vy: 0, radius: 0.25, axis: 0.5, front: 1.2, side: 0.6, rear: 0.5, group: -1, seen: true, ...more,
});

const shown = (people: PersonInfo[], bodies: Shown["true_people"] = []): Shown => ({ pose: [0, 0, 0], people, true_people: bodies });

function instances(group: Object3D): number[] {
  return group.children.map((each) => (each as InstancedMesh).count).sort();
}

describe("the chair", () => {
  it("fills its outline, and a seated person is 1.3 m high", () => {
    const box = new Box3().setFromObject(chairModel(CHAIR, COLOURS).group.children.at(-1)!);
    expect(box.max.x).toBeLessThan(0.66);
    expect(box.max.x).toBeGreaterThan(0.6);
    expect(box.min.x).toBeGreaterThan(-0.51);
    expect(box.max.z).toBeGreaterThan(1.25);
    expect(box.max.z).toBeLessThan(1.4);
    expect(box.min.z).toBeGreaterThan(-0.01);
  });

  it("looks along its heading: its footrests are ahead", () => {
    const made = chairModel(CHAIR, COLOURS);
    made.place([1, 2, Math.PI / 2], [0, 0], 0);
    const box = new Box3().setFromObject(made.group);
    expect(box.max.y).toBeGreaterThan(2.6); // x forward becomes y
    expect(box.min.y).toBeGreaterThan(2 - 0.75);
  });

  it("rolls its wheels without slip: 2π radii of way are one turn", () => {
    const made = chairModel(CHAIR, COLOURS);
    const angles: number[] = [];
    const before: number[] = [];
    made.group.traverse((each) => before.push(each.rotation.y));
    made.place([0, 0, 0], [0.5, 0], (2 * Math.PI * 0.178) / 0.5);
    made.group.traverse((each) => angles.push(each.rotation.y));
    const turned = angles.map((each, k) => each - before[k]!).filter((each) => each !== 0);
    expect(turned.map((each) => +each.toFixed(9))).toEqual([2 * Math.PI, 2 * Math.PI].map((each) => +each.toFixed(9)));
  });

  it("without room for a seat is a carrier", () => {
    const outline: ChairInfo["outline"] = [[0.25, 0.2], [-0.25, 0.2], [-0.25, -0.2], [0.25, -0.2]];
    const made = chairModel({ ...CHAIR, outline }, COLOURS);
    expect(made.rider).toBeNull();
    expect(new Box3().setFromObject(made.group).getSize(new Vector3()).x).toBeLessThan(0.51);
  });
});

describe("people", () => {
  it("are figures where the chair tracks them, and pale where it does not", () => {
    const people = new People(COLOURS);
    people.show(shown([person()], [[2.1, 1, 0.25], [8, 8, 0.25]]), true);
    // body, shadow, 4 parts of the space, 2 legs; and one pale figure in a dashed ring
    expect(instances(people.group)).toEqual([1, 1, 1, 1, 1, 1, 1, 1, 2]);
    people.show(shown([]), true);
    expect(people.group.children.every((each) => !each.visible)).toBe(true);
  });

  it("find room, however many they are", () => {
    const people = new People(COLOURS);
    people.show(shown(Array.from({ length: 70 }, (_, id) => person({ id, x: id }))), true);
    expect(Math.max(...instances(people.group))).toBe(140); // legs
  });

  it("have their space ahead of them along its axis", () => {
    const people = new People(COLOURS);
    people.show(shown([person({ axis: Math.PI / 2 })]), false);
    const sizes = people.group.children.map((each) => {
      const matrix = new Matrix4();
      (each as InstancedMesh).getMatrixAt(0, matrix);
      return new Vector3(1, 0, 0).applyMatrix4(matrix);
    });
    expect(sizes.some((at) => Math.abs(at.x - 2) < 1e-6 && Math.abs(at.y - (1 + 1.2)) < 1e-6)).toBe(true);
    expect(sizes.some((at) => Math.abs(at.y - (1 + 0.5)) < 1e-6)).toBe(true);
  });

  it("look where they walk, and along their space while they stand", () => {
    expect(headingOf(person({ vx: 0, vy: -1 }))).toBeCloseTo(-Math.PI / 2);
    expect(headingOf(person({ vx: 0.05 }))).toBe(0.5);
  });

  it("are freed with all that they hold", () => {
    const people = new People(COLOURS);
    people.show(shown([person()]), true);
    let freed = 0;
    people.group.traverse((each) => {
      if (each instanceof InstancedMesh) each.geometry.addEventListener("dispose", () => freed++);
    });
    const count = people.group.children.length;
    release(people.group);
    expect(freed).toBe(count);
    expect(people.group.children).toEqual([]);
  });
});

describe("the picture's detail", () => {
  it("is less where frames come too slowly, and no less than half", () => {
    const detail = new Detail(1);
    let now = 0;
    for (let k = 0; k < 400; k++) detail.drawn((now += 50));
    expect(detail.ratio).toBe(0.5);
  });

  it("stays where they come in time, and where nothing moved between them", () => {
    const quick = new Detail(1);
    const resting = new Detail(1);
    let now = 0;
    for (let k = 0; k < 400; k++) {
      quick.drawn((now += 17));
      resting.pause();
      resting.drawn(now * 10);
    }
    expect([quick.ratio, resting.ratio]).toEqual([1, 1]);
  });
});

describe("the view in words", () => {
  const state = {
    pose: [0, 0, 0] as const, speed: 0.8, turn_rate: 0, remaining: 12.4, arrived: false, reason: null,
    goal: { name: "Ward 4", x: 9, y: 9 }, people: [person({ x: 1.5, y: 1.5, vx: -0.7, vy: -0.7 })],
  };

  it("tells the chair, its trip and the nearest people", () => {
    expect(inWords(state)).toBe(
      "The chair drives forward at 0.8 m/s. 12 m remain to Ward 4. " +
        "1 person within 6 m: 2.1 m ahead on the left, coming nearer.",
    );
  });

  it("tells the nearest edge of the floor", () => {
    expect(inWords({ ...state, people: [], goal: null }, [{ x: -1, y: 1.2, width: 2, height: 0.05 }])).toBe(
      "The chair drives forward at 0.8 m/s. A step or an edge in the floor 1.2 m on the left. Nobody within 6 m.",
    );
  });

  it("tells why the chair stands, and that nobody is there", () => {
    const text = "Waiting for a person.";
    expect(inWords({ ...state, speed: 0, people: [], goal: null, reason: { code: "x", text } })).toBe(
      "The chair stands: Waiting for a person. Nobody within 6 m.",
    );
    expect(inWords(null)).toBe("Not connected to the chair.");
  });

  it("has y to the left", () => {
    expect([0, 0.8, 1.6, 2.4, 3.1, -0.8, -1.6].map(direction)).toEqual([
      "ahead", "ahead on the left", "on the left", "behind on the left", "behind", "ahead on the right", "on the right",
    ]);
  });
});
