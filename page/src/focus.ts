// The keyboard's place on the page: it survives every change of view.

/** What a keyboard can go to, in the order of preference for a part whose focused element went. */
const REACHED = "button, input, select, textarea, a[href], [tabindex='0']";

/**
 * Follows the focus within a page. Where its element goes away or is hidden, as of a panel that another
 * one replaces, it goes to the nearest part about it that is still there, else to `instead`; a screen
 * reader reads on from there. Returns what ends it.
 */
export function keepFocus(root: HTMLElement, instead: () => HTMLElement | null | undefined): () => void {
  /** The focused element and all that it was in, the innermost first. */
  let last: HTMLElement[] = [];
  const follow = ({ target }: FocusEvent): void => {
    last = [];
    for (let part = target as HTMLElement | null; part && part !== root; part = part.parentElement) last.push(part);
  };
  const look = (): void => {
    const [was, ...about] = last;
    if (!was || there(was) || (document.activeElement && document.activeElement !== document.body)) return;
    last = [];
    const part = about.find((each) => there(each) && each.querySelector(REACHED)) ?? instead();
    if (!part) return;
    if (!part.hasAttribute("tabindex")) part.tabIndex = -1;
    part.focus({ preventScroll: true });
  };
  const changes = new MutationObserver(look);
  changes.observe(root, { childList: true, subtree: true, attributeFilter: ["hidden", "disabled"] });
  root.addEventListener("focusin", follow);
  return () => {
    changes.disconnect();
    root.removeEventListener("focusin", follow);
  };
}

function there(part: HTMLElement): boolean {
  return part.isConnected && part.closest("[hidden]") === null && !(part as HTMLButtonElement).disabled;
}
