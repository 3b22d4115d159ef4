// STOP: repeated until the chair has received it, with the result in words.

import { chair } from "./chair.svelte";
import { t } from "./i18n/text.svelte";
import { inputs } from "./input/live";
import { link } from "./link";

/** Until it is said again, ms. */
const AGAIN = 150;
const TIMES = 10;

class StopButton {
  /** Text for screen readers; empty if there is nothing to say. */
  words = $state("");
  /** Problem in words; empty: none. */
  readonly trouble = $derived(this.words === t("stop.pressed") ? "" : this.words);

  constructor() {
    inputs.stopping = () => this.#pressed();
  }

  /** Called for every input device. */
  press(): void {
    inputs.stop();
  }

  #pressed(): void {
    if (chair.status !== "open") {
      this.words = t("stop.lost");
      void this.#asked();
      return;
    }
    this.words = t("stop.pressed");
    this.#check(TIMES);
  }

  /** The chair drives again. */
  over(): void {
    this.words = "";
  }

  /** Without a socket, as when there is room for no more pages: another one may be driving. */
  async #asked(): Promise<void> {
    try {
      if ((await fetch("/api/stop", { method: "POST" })).ok) this.words = t("stop.pressed");
    } catch {
      // what is said already holds
    }
  }

  #check(left: number): void {
    setTimeout(() => {
      if (chair.state?.link !== "ready") return;
      if (left === 0) {
        this.words = t("stop.notReceived");
        return;
      }
      link.send({ type: "stop" });
      this.#check(left - 1);
    }, AGAIN);
  }
}

export const stopButton = new StopButton();
