import { expect, it, vi } from "vitest";
import { press } from "./press";

function pointer(name: string, button = 0): Event {
  return new MouseEvent(name, { button, bubbles: true, detail: 1 });
}

it("acts as the finger comes down, and the click that follows is the same press", () => {
  const button = document.createElement("button");
  const act = vi.fn();
  const { update, destroy } = press(button, act);
  button.dispatchEvent(pointer("pointerdown"));
  expect(act).toHaveBeenCalledTimes(1);
  button.dispatchEvent(pointer("click"));
  expect(act).toHaveBeenCalledTimes(1);
  button.click(); // by key or by a screen reader
  expect(act).toHaveBeenCalledTimes(2);
  button.dispatchEvent(pointer("pointerdown", 2));
  expect(act).toHaveBeenCalledTimes(2);
  const other = vi.fn();
  update(other);
  button.dispatchEvent(pointer("pointerdown"));
  expect(other).toHaveBeenCalledTimes(1);
  destroy();
  button.click();
  expect(other).toHaveBeenCalledTimes(1);
});

it("acts at once too while another mouse button is held", () => {
  const button = document.createElement("button");
  const act = vi.fn();
  press(button, act);
  button.dispatchEvent(pointer("pointerdown", 2));
  button.dispatchEvent(new MouseEvent("pointermove", { button: -1, buttons: 2 }));
  expect(act).not.toHaveBeenCalled();
  button.dispatchEvent(new MouseEvent("pointermove", { button: 0, buttons: 3 }));
  expect(act).toHaveBeenCalledTimes(1);
  button.dispatchEvent(new MouseEvent("pointermove", { button: 0, buttons: 2 }));
  button.dispatchEvent(pointer("click"));
  expect(act).toHaveBeenCalledTimes(1);
});
