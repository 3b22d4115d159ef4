// Auto, light, dark or high contrast; kept on this device only. CSS knows palettes, not choices.

export const THEMES = ["auto", "light", "dark", "contrast"] as const;
export type Theme = (typeof THEMES)[number];
export type Palette = Exclude<Theme, "auto">;

const KEY = "cohelm.theme";
const MORE_CONTRAST = "(prefers-contrast: more)";
const DARK = "(prefers-color-scheme: dark)";

export function theme(): Theme {
  const kept = stored();
  return THEMES.find((each) => each === kept) ?? "auto";
}

/** Palette of a theme, given what the device prefers. */
export function paletteOf(chosen: Theme, prefers: { contrast: boolean; dark: boolean }): Palette {
  if (chosen !== "auto") return chosen;
  if (prefers.contrast) return "contrast";
  return prefers.dark ? "dark" : "light";
}

/** Puts the palette on the page. */
export function applyTheme(chosen: Theme = theme()): void {
  const prefers = { contrast: matchMedia(MORE_CONTRAST).matches, dark: matchMedia(DARK).matches };
  document.documentElement.dataset.palette = paletteOf(chosen, prefers);
}

export function chooseTheme(chosen: Theme): void {
  try {
    localStorage.setItem(KEY, chosen);
  } catch {
    // A device that keeps nothing shows the choice until it is reloaded.
  }
  applyTheme(chosen);
}

/** Follows the device when it changes its mind; returns what ends that. */
export function followDevice(): () => void {
  const change = (): void => applyTheme();
  const queries = [matchMedia(MORE_CONTRAST), matchMedia(DARK)];
  for (const query of queries) query.addEventListener("change", change);
  return () => queries.forEach((query) => query.removeEventListener("change", change));
}

function stored(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}
