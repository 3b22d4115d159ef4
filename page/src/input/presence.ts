/** Tells whether somebody can be looking at this page and it has the keyboard.
 *
 * Hidden, minimised, another window in front, left or frozen: not. A dialog of the page, or a
 * frame in it that takes the focus, is still the page. A touch or a key is proof of a person.
 *
 * Returns what ends the watch. */
export function watchPresence(window: Window, tell: (present: boolean) => void): () => void {
  const { document } = window;
  const shown = () => document.visibilityState === "visible";
  const look = () => tell(shown() && document.hasFocus());
  const leave = () => tell(false);
  const touched = () => tell(shown());
  const blurred = (event: Event) => {
    if (event.target instanceof Node) return; // focus wanders within the page
    const inFrame = document.activeElement?.tagName === "IFRAME";
    if (!(inFrame && shown() && document.hasFocus())) leave();
  };
  const ends = [
    on(document, "visibilitychange", look),
    on(document, "freeze", leave),
    on(document, "resume", look),
    on(window, "pagehide", leave),
    on(window, "pageshow", look),
    on(window, "blur", blurred),
    on(window, "focus", look),
    on(window, "pointerdown", touched),
    on(window, "keydown", touched),
  ];
  look();
  return () => ends.forEach((end) => end());
}

function on(target: EventTarget, name: string, act: (event: Event) => void): () => void {
  target.addEventListener(name, act, { capture: true });
  return () => target.removeEventListener(name, act, { capture: true });
}
