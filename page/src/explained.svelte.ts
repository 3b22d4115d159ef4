// What has been explained to this rider, modes and the ring of directions; kept on this device.

import type { Mode } from "./words";

const KEPT = "cohelm.explained";

/** What is explained at first use. */
export type Topic = Mode | "ring";

class Explained {
  topics = $state.raw<readonly string[]>(kept());

  has(topic: Topic): boolean {
    return this.topics.includes(topic);
  }

  mark(topic: Topic): void {
    if (this.has(topic)) return;
    this.topics = [...this.topics, topic];
    try {
      localStorage.setItem(KEPT, JSON.stringify(this.topics));
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
