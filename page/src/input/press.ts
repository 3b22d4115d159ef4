/** Calls `act` the moment a control is touched, and once only.
 *
 * A click comes when the finger lifts, and for a second finger often not at all: not good enough
 * for STOP while the other hand holds the stick. Keys and screen readers still click. For
 * `<button use:press={act}>`. */
export function press(node: HTMLElement, act: () => void): { destroy(): void; update(act: () => void): void } {
  let doing = act;
  let touched = -Infinity;
  const down = (event: PointerEvent) => {
    if (event.button !== 0) return;
    touched = event.timeStamp;
    doing();
  };
  // While another mouse button is held, the browser tells of this one as of a movement.
  const chord = (event: PointerEvent) => {
    if (event.buttons & 1) down(event);
  };
  const click = (event: MouseEvent) => {
    const ofTouch = event.detail > 0 && event.timeStamp - touched < SAME_PRESS;
    if (!ofTouch) doing();
  };
  node.addEventListener("pointerdown", down);
  node.addEventListener("pointermove", chord);
  node.addEventListener("click", click);
  return {
    update: (next) => (doing = next),
    destroy() {
      node.removeEventListener("pointerdown", down);
      node.removeEventListener("pointermove", chord);
      node.removeEventListener("click", click);
    },
  };
}

/** A click within this of the touch is the same press, ms. */
const SAME_PRESS = 3_000;
