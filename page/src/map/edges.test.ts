import { describe, expect, it, vi } from "vitest";
import { chair } from "../chair.svelte";
import type { FloorInfo, ToPage } from "../messages";
import { surroundings } from "../surroundings.svelte";
import { tiles } from "../view3d/markings";
import { boxesOf, drawEdges, nearestEdge } from "./edges";
import type { Colours } from "./palette";
import type { Box, Point } from "./view";

const FLOOR: FloorInfo = { image: "", width: 40, height: 20, resolution: 0.5, x: -1, y: 2 };
const BOX: Box = { x: 0, y: 2.5, width: 1.5, height: 0.5 };

describe("edges of the floor", () => {
  it("are boxes of the map: rows from below, columns from the left", () => {
    expect(boxesOf([[1, 2, 3]], FLOOR)).toEqual([BOX]);
  });

  it("are those of the newest message, until the page connects anew", () => {
    const heard = (message: object): void => chair.heard(message as ToPage);
    const welcome = { type: "welcome", scene: { floor: FLOOR, places: [] } };
    heard(welcome);
    heard({ type: "edge_cells", runs: [[1, 2, 3]] });
    expect(chair.edges).toEqual([BOX]);
    heard(welcome);
    expect(chair.edges).toEqual([]);
  });

  it("are pointed at where they are nearest, ahead before behind", () => {
    const behind: Box = { ...BOX, x: -2, width: 1.2 };
    expect(nearestEdge([-0.5, 2.6, 0], [behind, BOX], 2)).toEqual([0, 2.6]);
    expect(nearestEdge([-0.5, 2.6, Math.PI], [behind, BOX], 2)).toEqual([-0.8, 2.6]);
    expect(nearestEdge([1.6, 2.6, 0], [BOX], 2)).toEqual([1.5, 2.6]);
    expect(nearestEdge([4, 2.6, 0], [BOX], 2)).toBeNull();
  });

  it("are the cause of a stop that names one, and of no other stop", () => {
    const stops = (code: string, now: number): void => {
      chair.heard({
        type: "state", pose: [-1, 2.6, 0], speed: 0, command: [0, 0], link: "ready", remaining: null, people: [], free: [], closed_doors: [],
        reason: { code, text: code },
      } as unknown as ToPage);
      for (let later = 0; later < 2_000; later += 100) surroundings.look(now + later);
    };
    chair.heard({ type: "welcome", scene: { floor: FLOOR, places: [], doors: [] } } as unknown as ToPage);
    chair.edges = [BOX];
    stops("edge_ahead", 10_000);
    expect(surroundings.cause).toEqual({ thing: "edge", at: [0, 2.6] });
    stops("keepout", 20_000);
    expect(surroundings.cause).toBeNull();
  });

  it("are one outlined shape on a map that is turned", () => {
    const corners: Point[] = [];
    const push = (x: number, y: number): void => void corners.push([Math.round(x), Math.round(y)]);
    const context = { beginPath: vi.fn(), closePath: vi.fn(), moveTo: push, lineTo: push, stroke: vi.fn(), fill: vi.fn(), createPattern: () => null };
    const colours = { warn: "#000000", warnGround: "#ffffff" } as Colours;
    const view = { at: [0, 2], middle: [100, 100], scale: 20, turn: Math.PI / 2 } as const;
    vi.spyOn(HTMLCanvasElement.prototype, "getContext").mockReturnValue(null);
    drawEdges(context as unknown as CanvasRenderingContext2D, [BOX], colours, view);
    expect(corners).toEqual([[90, 100], [90, 70], [80, 70], [80, 100]]);
    expect([context.stroke, context.fill].map((each) => each.mock.calls.length)).toEqual([1, 1]);
  });

  it("face up in the 3-D view", () => {
    const { positions, indices } = tiles([BOX, BOX], 0.01);
    expect(positions.slice(0, 9)).toEqual([0, 2.5, 0.01, 1.5, 2.5, 0.01, 1.5, 3, 0.01]);
    expect(indices).toEqual([0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
  });
});
