import { fireEvent, render, screen } from "@testing-library/svelte";
import { beforeEach, describe, expect, it } from "vitest";
import { Chair } from "../chair.svelte";
import { CENTRE, type Deflection } from "./deflection";
import { Inputs } from "./inputs.svelte";
import Joystick from "./Joystick.svelte";

let pulled: Deflection[];
let inputs: Inputs;

beforeEach(() => {
  pulled = [];
  inputs = new Inputs({ send: () => true, watch: () => () => undefined, again: () => undefined }, new Chair());
  inputs.pull = (at) => void pulled.push(at);
  render(Joystick, { inputs, usable: true });
  Object.defineProperty(stick(), "clientWidth", { value: 100 }); // full deflection is 36 px
});

const stick = () => screen.getByTestId("joystick");

/** As jsdom has no pointers of its own. */
async function pointer(name: string, id: number, x: number, y: number, button = 0, buttons = 0): Promise<void> {
  const event = new MouseEvent(name, { bubbles: true, cancelable: true, clientX: x, clientY: y, button, buttons });
  await fireEvent(stick(), Object.assign(event, { pointerId: id }));
}

describe("joystick", () => {
  it("is centred where it is touched, follows the finger and springs back", async () => {
    await pointer("pointerdown", 1, 90, 20);
    expect(pulled.at(-1)).toEqual(CENTRE);
    await pointer("pointermove", 1, 90, 2);
    expect(pulled.at(-1)).toEqual({ forward: 0.5, left: 0 });
    await pointer("pointerup", 1, 90, 2);
    expect(pulled.at(-1)).toEqual(CENTRE);
  });

  it.each(["pointerup", "pointercancel", "lostpointercapture"])("springs back at %s", async (name) => {
    await pointer("pointerdown", 1, 50, 50);
    await pointer("pointermove", 1, 50, 0);
    await pointer(name, 1, 50, 0);
    expect(pulled.at(-1)).toEqual(CENTRE);
    const count = pulled.length;
    await pointer("pointermove", 1, 0, 0);
    expect(pulled).toHaveLength(count);
  });

  it("belongs to one finger, and to the main button", async () => {
    await pointer("pointerdown", 1, 50, 50, 2);
    expect(pulled).toEqual([]);
    await pointer("pointerdown", 1, 50, 50);
    await pointer("pointermove", 1, 50, 14);
    await pointer("pointerdown", 2, 80, 80);
    await pointer("pointermove", 2, 0, 0);
    await pointer("pointerup", 2, 0, 0);
    expect(pulled.at(-1)).toEqual({ forward: 1, left: 0 });
  });

  it("is let go with the main button, though another one is held", async () => {
    await pointer("pointerdown", 1, 50, 50, 0, 1);
    await pointer("pointermove", 1, 50, 14, 2, 3);
    expect(pulled.at(-1)).toEqual({ forward: 1, left: 0 });
    await pointer("pointermove", 1, 50, 14, 0, 2);
    expect(pulled.at(-1)).toEqual(CENTRE);
  });

  it("is let go when the page is left", async () => {
    await pointer("pointerdown", 1, 50, 50);
    await pointer("pointermove", 1, 50, 14);
    inputs.present = false;
    await Promise.resolve();
    expect(pulled.at(-1)).toEqual(CENTRE);
  });
});
