// Which modes have been explained to this rider; kept on this device.

import type { Mode } from "./words";

const KEPT = "cohelm.explained";

class Explained {
  modes = $state.raw<readonly string[]>(kept());

  has(mode: Mode): boolean {
    return this.modes.includes(mode);
  }

  mark(mode: Mode): void {
    if (this.has(mode)) return;
    this.modes = [...this.modes, mode];
    try {
      localStorage.setItem(KEPT, JSON.stringify(this.modes));
    } catch {
      // A device that keeps nothing explains again the next time.
    }
  }
}

function kept(): readonly string[] {
  try {
    const found: unknown = JSON.parse(localStorage.getItem(KEPT) ?? "[]");
    return Array.isArray(found) ? found.map(String) : [];
  } catch {
    return [];
  }
}

export const explained = new Explained();
