// One or two switches: what is lit on the page, and what a press does to it.

import type { Inputs } from "./inputs.svelte";
import { isTyped } from "./keys";
import { reach, type Reached } from "./reach";
import { begun, litOf, RESTING, selected, stepped, ticked, type Choice, type Scan } from "./scan";
import {
  closing, keepSwitches, keptSwitches, mayBeSwitch, meaning, OPEN, opening, settled, type Contact, type SwitchSettings,
} from "./switches";

export type Switch = "choose" | "step";

/** A press of a switch so soon after it let go is the same shaking hand, ms (assumed). */
const SHAKING = 150;
/** Dwell until the chair says the rider's, s. */
const DWELL = 1.2;
/** On a choice that is about to be ready, the light waits so long at most, ms (assumed). */
const WAITS = 10_000;
/** Period of searching the page for reachable items, ms. */
const SEARCH = 200;

export class Scanner {
  settings = $state.raw<SwitchSettings>(keptSwitches());
  /** Highlighted item; null: the scan pauses. */
  lit = $state.raw<Choice | null>(null);
  /** The next key becomes this switch. */
  learning = $state<Switch | null>(null);

  #scan: Scan = RESTING;
  #choices: readonly Reached[] = [];
  #searched = -Infinity;
  /** The element that was chosen, until the light is where that led. */
  #chosen: HTMLElement | null = null;
  /** Since when the light is where a choice led, ms. */
  #landed = -Infinity;
  #contacts: Readonly<Record<Switch, Contact>> = { choose: OPEN, step: OPEN };
  #letGo: { readonly by: Switch; readonly at: number } | null = null;
  #marked: readonly HTMLElement[] = [];
  /** Number of switches that the therapist has set, as far as it was applied. */
  #prescribed: number | null = null;

  constructor(readonly inputs: Inputs) {}

  get dwell(): number {
    return 1000 * (this.inputs.chair.rider?.dwell ?? DWELL);
  }

  /** Meaning of a switch press in the current state. */
  get meaning(): "choose" | "let-go" | "stop" {
    const { chair, push } = this.inputs;
    return meaning(chair.state, push, chair.driving);
  }

  change(settings: Partial<SwitchSettings>): void {
    this.settings = { ...this.settings, ...settings };
    keepSwitches(this.settings);
    this.#contacts = { choose: OPEN, step: OPEN };
    this.#scan = RESTING;
    this.#show();
  }

  tick(now: number): void {
    this.#prescribe();
    if (this.settings.count === 0) return;
    this.#touch("choose", settled);
    this.#touch("step", settled);
    if (now - this.#searched >= SEARCH) {
      this.#searched = now;
      this.#choices = reach(document);
    }
    this.#land(now);
    if (this.meaning !== "choose") {
      this.#scan = begun(this.#choices, now, this.dwell);
    } else if (now - this.#landed < WAITS && this.#marked[0]?.ariaBusy === "true") {
      this.#scan = { ...this.#scan, since: Math.max(this.#scan.since, now) };
    } else if (this.settings.count === 1 && this.inputs.present) {
      this.#scan = ticked(this.#scan, this.#choices, { dwell: this.dwell }, now);
    }
    this.#show();
  }

  /** Applies the therapist's number of switches once; the rider may change it afterwards. */
  #prescribe(): void {
    const count = this.inputs.chair.rider?.switches ?? null;
    if (count === this.#prescribed) return;
    this.#prescribed = count;
    if (count !== null && count !== this.settings.count) this.change({ count });
  }

  /** A switch's contact closes. */
  down(which: Switch): void {
    this.#touch(which, closing);
  }

  /** A switch's contact opens. */
  up(which: Switch): void {
    this.#touch(which, opening);
  }

  #touch(which: Switch, change: typeof settled): void {
    const was = this.#contacts[which];
    const next = change(was, performance.now(), this.settings.bounce);
    this.#contacts = { ...this.#contacts, [which]: next };
    if (next.down && !(was.down && was.counted === next.counted)) this.#press(which);
    else if (was.down && !next.down) this.#release(which);
  }

  /** While the chair moves any switch stops it; only a fresh press chooses. */
  #press(which: Switch): void {
    const now = performance.now();
    const { inputs } = this;
    const means = this.meaning;
    if (means === "let-go") {
      this.#letGo = { by: which, at: now };
      inputs.letGo();
    } else if (this.#letGo?.by === which && now - this.#letGo.at < SHAKING) {
      return;
    } else if (means === "stop") {
      inputs.stop();
    } else if (this.#contacts[which].fresh) {
      this.#choices = reach(document);
      if (which === "step" && this.settings.count === 2) {
        this.#scan = stepped(this.#scan, this.#choices, now);
      } else {
        this.#choose(now);
      }
    }
    this.#show();
  }

  /** Where the switch that chooses drives only while it is held, that ends. */
  #release(which: Switch): void {
    if (which === "choose" && this.settings.hold && this.inputs.push) this.inputs.letGo();
  }

  /** True if the key belongs to a switch, or just became one. */
  keyDown(event: KeyboardEvent): boolean {
    if (this.learning) return this.#learn(event);
    const which = this.#switchOf(event);
    if (!which) return false;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat) this.down(which);
    return true;
  }

  keyUp(event: KeyboardEvent): void {
    if (this.#switchOf(event)) event.preventDefault(); // else a focused button is clicked as the key comes up
    const which = this.#named(event.code);
    if (which) this.up(which); // wherever the focus went since it came down
  }

  #choose(now: number): void {
    const { scan, chosen } = selected(this.#scan, this.#choices, now, this.#pause);
    this.#scan = scan;
    if (!chosen) return;
    this.#chosen = elementsOf(this.#choices, chosen.key)[0] ?? null;
    this.#chosen?.click();
    this.#searched = -Infinity;
  }

  get #pause(): number {
    return this.settings.count === 1 ? this.dwell : 0;
  }

  /** After a choice, when the page has changed: to the first row of what it opened, else to the first choice of all. */
  #land(now: number): void {
    const controlled = this.#chosen?.getAttribute("aria-controls");
    if (!this.#chosen) return;
    this.#chosen = null;
    this.#landed = now;
    const opened = controlled ? document.getElementById(controlled) : null;
    const first = opened && this.#choices.find(({ elements }) => opened.contains(elements[0] ?? null));
    this.#scan = { ...begun(this.#choices, now, this.#pause), ...(first ? { lit: first.key } : {}) };
  }

  /** Letters and spaces that are typed stay typed, and the switches' own settings keep their
   * keys, but only while the chair stands. */
  #switchOf(event: KeyboardEvent): Switch | null {
    const { target } = event;
    const own = target instanceof Element && target.closest("[data-own-keys]") !== null;
    const typed = isTyped(target) && !isButton(target);
    // A radio button that is chosen has no use for them: right after the set-up the focus is there.
    const set = target instanceof Element && target.matches("[type=radio]:checked");
    return (own || typed) && !set && this.meaning === "choose" ? null : this.#named(event.code);
  }

  #named(code: string): Switch | null {
    const { count, choose, step } = this.settings;
    if (count > 0 && code === choose) return "choose";
    return count === 2 && code === step ? "step" : null;
  }

  #learn(event: KeyboardEvent): boolean {
    event.preventDefault();
    event.stopPropagation();
    const { learning } = this;
    if (event.repeat || !learning) return true;
    this.learning = null;
    if (event.target instanceof HTMLElement) event.target.blur(); // else the new switch presses the button again
    if (!mayBeSwitch(event.code)) return true;
    const other = learning === "choose" ? "step" : "choose";
    const before = this.settings[learning];
    const swapped = this.settings[other] === event.code ? { [other]: before } : {};
    this.change({ [learning]: event.code, ...swapped });
    return true;
  }

  /** Marks on the page what is lit. */
  #show(): void {
    const on = this.settings.count > 0 && this.meaning === "choose";
    const lit = on ? litOf(this.#scan, this.#choices) : null;
    if (lit?.key !== this.lit?.key || lit?.label !== this.lit?.label) this.lit = lit;
    const elements = lit ? elementsOf(this.#choices, lit.key) : [];
    if (elements.length === this.#marked.length && elements.every((e, n) => e === this.#marked[n])) return;
    for (const element of this.#marked) element.removeAttribute("data-scanned");
    for (const element of elements) element.setAttribute("data-scanned", "");
    elements[0]?.scrollIntoView?.({ block: "nearest" });
    this.#marked = elements;
  }
}

function isButton(target: EventTarget | null): boolean {
  return target instanceof Element && target.closest("button") !== null;
}

function elementsOf(choices: readonly Reached[], key: string): readonly HTMLElement[] {
  for (const choice of choices) {
    if (choice.key === key) return choice.elements;
    const inside = elementsOf(choice.items ?? [], key);
    if (inside.length > 0) return inside;
  }
  return [];
}
