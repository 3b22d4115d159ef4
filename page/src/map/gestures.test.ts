// @vitest-environment node
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Gestures } from "./gestures";

const meaning = { tap: vi.fn(), pan: vi.fn(), zoom: vi.fn(), draw: vi.fn(), drawn: vi.fn() };
let gestures: Gestures;

beforeEach(() => {
  vi.clearAllMocks();
  gestures = new Gestures(meaning);
});

describe("one finger", () => {
  it("touches, even if it shakes a little", () => {
    gestures.down(1, [10, 10]);
    gestures.move(1, [14, 12]);
    gestures.up(1, [14, 12]);
    expect(meaning.tap).toHaveBeenCalledWith([14, 12]);
    expect(meaning.pan).not.toHaveBeenCalled();
  });

  it("moves the map by as much as it moves", () => {
    gestures.down(1, [10, 10]);
    gestures.move(1, [30, 10]);
    gestures.move(1, [35, 20]);
    gestures.up(1, [35, 20]);
    expect(meaning.pan.mock.calls).toEqual([[20, 0], [5, 10]]);
    expect(meaning.tap).not.toHaveBeenCalled();
  });

  it("draws where it is asked to", () => {
    gestures.drawing = true;
    gestures.down(1, [0, 0]);
    gestures.move(1, [20, 0]);
    gestures.up(1, [20, 0]);
    expect(meaning.drawn).toHaveBeenCalledWith([[0, 0], [20, 0]]);
    expect(meaning.pan).not.toHaveBeenCalled();
  });
});

describe("two fingers", () => {
  it("zoom about their middle, and touch nothing", () => {
    gestures.down(1, [0, 0]);
    gestures.down(2, [100, 0]);
    gestures.move(2, [200, 0]);
    gestures.up(2, [200, 0]);
    gestures.up(1, [0, 0]);
    expect(meaning.zoom).toHaveBeenCalledWith(2, [100, 0]);
    expect(meaning.tap).not.toHaveBeenCalled();
  });

  it("give a line up that the first began", () => {
    gestures.drawing = true;
    gestures.down(1, [0, 0]);
    gestures.move(1, [20, 0]);
    gestures.down(2, [100, 0]);
    expect(meaning.drawn).toHaveBeenCalledWith(null);
    gestures.up(2, [100, 0]);
    gestures.up(1, [20, 0]);
    expect(meaning.drawn).toHaveBeenCalledTimes(1);
  });
});
