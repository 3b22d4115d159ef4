import { render, screen } from "@testing-library/svelte";
import { afterEach, expect, it, vi } from "vitest";
import Timeline from "./Timeline.svelte";

const RIDE = {
  period: 0.2, pose: [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]], speed: [0, 0.64, -0.2], eta: [0, 0.5, 1],
  stick: [[0, 0], [1, 0], [0, 0]], people: [[], [], []], reasons: [{ time: 0.2, duration: 0.2, code: "blocked", text: "" }],
  route: [], goal: null, outline: [], floor: { image: "", x: 0, y: 0, width: 1, height: 1, resolution: 1 },
};

vi.mock("../server", () => ({ ask: () => Promise.resolve({ ok: true, value: RIDE }) }));
vi.stubGlobal("ResizeObserver", class {
  observe(): void {
    // Nothing has a size here.
  }
  unobserve(): void {
    // As above.
  }
  disconnect(): void {
    // As above.
  }
});
vi.stubGlobal("Image", class {
  src = "";
  naturalWidth = 0;
  decode = (): Promise<void> => Promise.resolve();
});

afterEach(() => vi.unstubAllGlobals());

it("has a scale with its unit at each curve", async () => {
  const { container } = render(Timeline, { address: "/ride" });
  await screen.findByRole("slider", { name: "Time in the ride" });
  const scales = [...container.querySelectorAll(".plot .scale")].map((each) => [...each.children].map((bound) => bound.textContent));
  expect(scales).toEqual([["0.6 m/s", "-0.2 m/s"], ["100 %", "0 %"], ["100 %", "0 %"]]);
  expect(screen.getByText("Shaded: something held the chair.")).toBeTruthy();
});
