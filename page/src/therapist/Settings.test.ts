import { fireEvent, render, screen } from "@testing-library/svelte";
import { describe, expect, it, vi } from "vitest";
import { LIMITS, type Outcome } from "./limits";
import Settings from "./Settings.svelte";

const DONE = { done: true, text: "Saved." };
const NOW = { max_speed: 1, max_acceleration: 0.6, min_distance: 0.45 };

function shown(save: (next: typeof NOW) => Promise<Outcome>, warn?: () => string) {
  render(Settings, { title: "Limits", quantities: LIMITS, now: NOW, save, ...(warn && { warn }) } as never);
  return {
    speed: screen.getByLabelText("Maximum speed, m/s"),
    save: screen.getByRole<HTMLButtonElement>("button", { name: "Apply" }),
  };
}

describe("limits on the page", () => {
  it("are put in force together, and only where they differ", async () => {
    const save = vi.fn(async () => DONE);
    const page = shown(save);
    expect(page.save.disabled).toBe(true);
    await fireEvent.input(page.speed, { target: { value: "0.6" } });
    expect(page.save.disabled).toBe(false);
    await fireEvent.click(page.save);
    expect(save).toHaveBeenCalledWith({ ...NOW, max_speed: 0.6 });
    expect(await screen.findByText("Saved. Applied: Maximum speed 1 m/s.")).toBeTruthy(); // what the chair says
  });

  it("say the server's refusal, and keep what was typed", async () => {
    const page = shown(async () => ({ done: false, text: "The speed can be loosened only while the chair stands." }));
    await fireEvent.input(page.speed, { target: { value: "1.2" } });
    await fireEvent.click(page.save);
    expect((await screen.findByRole("alert")).textContent).toContain("only while the chair stands");
    expect((page.speed as HTMLInputElement).value).toBe("1.2");
  });

  it("are not sent outside their bounds", async () => {
    const save = vi.fn(async () => DONE);
    const page = shown(save);
    await fireEvent.input(page.speed, { target: { value: "9" } });
    expect(page.save.disabled).toBe(true);
    expect(screen.getByText("Between 0.1 and 3 m/s.")).toBeTruthy();
    expect(page.speed.getAttribute("aria-invalid")).toBe("true");
  });

  it("warn beforehand", async () => {
    const page = shown(async () => DONE, () => "The chair moves.");
    expect(screen.queryByText("The chair moves.")).toBeNull();
    await fireEvent.input(page.speed, { target: { value: "1.2" } });
    expect(screen.getByText("The chair moves.")).toBeTruthy();
  });
});
