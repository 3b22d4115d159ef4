// All input devices combined: devices in, one deflection out.

import { Chair, chair as theChair } from "../chair.svelte";
import type { FromPage } from "../messages";
import { dropped, gone, NOBODY, read, steering, type Arbiter, type Source, type Steering } from "./arbiter";
import { CENTRE, type Deflection } from "./deflection";
import { Heartbeat } from "./heartbeat";
import { isControl, isTyped, keyed, NO_KEYS, pressed, released, steers, type Keys } from "./keys";
import {
  connectedPads, isFrozen, newlyPressed, padDeflection, padReading, withStartDown, type Pad, type PadReading,
} from "./pads";
import { watchPresence } from "./presence";
import { Scanner } from "./scanner.svelte";
import { isMoving, isOver, pushed, type Direction, type Push } from "./switches";

/** Polling period of gamepads, ramps and switches, ms. */
const EVERY = 20;
/** A page in front that drives and is not heard for longer than this connects anew, ms (assumed):
 * after its clock stood still, the chair takes every beat of the old connection for a late one. */
const UNHEARD = 2_000;
/** A state older than this is confirmed no more, ms (assumed); less than the silence of 2 s after which
 * the chair itself asks for a confirmation. */
const SHOWN = 1_000;
/** Until the chair says otherwise. */
const DEAD_ZONE = 0.08;

/** Interface of the link as the inputs use it. */
export interface Line {
  send(message: FromPage): boolean;
  watch(watcher: (status: string) => void): () => void;
  /** Begins the connection anew. */
  again(): void;
}

export class Inputs {
  /** Deflection sent to the chair, and the sources that must be released first. */
  steering = $state.raw<Steering>({ at: CENTRE, device: "none", waiting: [] });
  /** True if the page is in front and has the keyboard. */
  present = $state(true);
  /** Number of connected gamepads. */
  pads = $state(0);
  /** True if a deflected gamepad is not heeded because it looks dead. */
  frozen = $state(false);
  /** A direction that a switch drives. */
  push = $state.raw<Push | null>(null);
  readonly scanner: Scanner;
  /** Called for every STOP of this page, from any device. */
  stopping: () => void = () => undefined;

  #arbiter: Arbiter = NOBODY;
  #keys: Keys = NO_KEYS;
  #spaceStopped = false;
  #readings = new Map<number, PadReading>();
  #pulse: Heartbeat;
  /** Since when the chair does not hear this page, ms; null: it does, or need not. */
  #unheard: number | null = null;

  constructor(
    readonly line: Line,
    readonly chair: Chair = theChair,
  ) {
    this.#pulse = new Heartbeat((beat) => line.send(beat));
    this.scanner = new Scanner(this);
  }

  get deadZone(): number {
    return this.chair.rider?.dead_zone ?? DEAD_ZONE;
  }

  /** Listens from now on; returns what ends it. */
  start(): () => void {
    const timer = setInterval(() => this.look(), EVERY);
    const ends = [
      () => clearInterval(timer),
      this.line.watch((status) => this.#linked(status === "open")),
      watchPresence(window, (present) => this.#seen(present)),
      heard("keydown", (event) => this.#keyDown(event)),
      heard("keyup", (event) => this.#keyUp(event)),
    ];
    return () => {
      ends.forEach((end) => end());
      this.#pulse.disconnected();
    };
  }

  /** The on-screen stick is pulled so far; its centre when it is let go. */
  pull(at: Deflection): void {
    this.#arbitrate("joystick", at);
  }

  stop(): void {
    this.push = null;
    this.line.send({ type: "stop" });
    this.#arbitrate("switch", CENTRE);
    this.stopping();
  }

  /** Confirm that the chair may move, if the rider has just been shown that it waits for that.
   *
   * After a moment in which the page was busy the chair may have stopped, and the page not know it. */
  resume(): void {
    const { state, came } = this.chair;
    if (state?.link !== "confirm" || state.not_ready || performance.now() - came > SHOWN) return;
    for (const pad of connectedPads(navigator)) this.#arbitrate(`gamepad:${pad.index}`, padDeflection(pad));
    this.#pulse.assure();
    this.line.send({ type: "resume" });
  }

  /** A switch drives in this direction, until it is pressed again or for as long as it may. */
  drive(direction: Direction): void {
    if (!this.chair.driving || this.chair.state?.link !== "ready") return;
    this.push = { direction, since: performance.now() };
    this.look();
  }

  /** Release the direction that a switch drives. */
  letGo(): void {
    this.push = null;
    this.look();
  }

  /** Reads every device that does not speak up by itself. */
  look(): void {
    const now = performance.now();
    this.#lookAtPads(now);
    this.#arbitrate("keys", keyed(this.#keys, now));
    if (this.push && (isOver(this.push, now) || this.chair.state?.link !== "ready")) {
      this.push = null;
    }
    this.#arbitrate("switch", pushed(this.push, now));
    this.scanner.tick(now);
    this.#lookAtLink(now);
  }

  #lookAtLink(now: number): void {
    const { driving, stale, state } = this.chair;
    const unheard = this.present && driving && !stale && state?.link === "no_heartbeat";
    this.#unheard = unheard ? (this.#unheard ?? now) : null;
    if (this.#unheard === null || now - this.#unheard <= UNHEARD) return;
    this.#unheard = null;
    this.line.again();
  }

  #lookAtPads(now: number): void {
    const pads = connectedPads(navigator);
    if (pads.length !== this.pads) this.pads = pads.length;
    for (const index of this.#readings.keys()) {
      if (pads.some((pad) => pad.index === index)) continue;
      this.#readings.delete(index);
      this.#arbiter = gone(this.#arbiter, `gamepad:${index}`);
      this.#tell();
    }
    const dead = pads.filter((pad) => this.#lookAt(pad, now)).map((pad): Source => `gamepad:${pad.index}`);
    this.frozen = dead.some((source) => this.steering.waiting.includes(source));
  }

  /** True if it looks dead. */
  #lookAt(pad: Pad, now: number): boolean {
    const source: Source = `gamepad:${pad.index}`;
    const was = this.#readings.get(pad.index);
    const reading = padReading(pad, was, now);
    this.#readings.set(pad.index, reading);
    const frozen = isFrozen(pad, reading, now);
    if (frozen) this.#arbiter = dropped(this.#arbiter, source);
    this.#arbitrate(source, padDeflection(pad));
    const pressed = newlyPressed(pad, was);
    if (pressed.stop) this.stop();
    else if (pressed.resume && this.present) this.resume();
    return frozen;
  }

  #arbitrate(source: Source, at: Deflection): void {
    this.#arbiter = read(this.#arbiter, source, at, this.deadZone);
    this.#tell();
  }

  #tell(): void {
    const now = steering(this.#arbiter, this.deadZone);
    if (!isSame(now, this.steering)) this.steering = now;
    if (this.present) this.#pulse.put(now.at, now.device);
  }

  #linked(open: boolean): void {
    this.push = null;
    if (open) this.#pulse.connected();
    else this.#pulse.disconnected();
  }

  #seen(present: boolean): void {
    if (present === this.present) return;
    if (!present) {
      this.#keys = NO_KEYS;
      this.push = null;
      this.#arbiter = dropped(this.#arbiter);
    }
    for (const [index, reading] of this.#readings) this.#readings.set(index, withStartDown(reading));
    this.present = present;
    this.#pulse.present(present);
    for (const source of ["joystick", "keys", "switch"] as const) this.#arbitrate(source, CENTRE);
  }

  #keyDown(event: KeyboardEvent): void {
    if (event.code === "Escape") {
      this.scanner.learning = null;
      if (!event.repeat) this.stop();
      return;
    }
    if (this.scanner.keyDown(event)) return;
    const { driving } = this.chair;
    const modified = event.ctrlKey || event.metaKey || event.altKey;
    if (driving && event.code === "Space" && this.#stops(event.target, modified)) {
      event.preventDefault();
      this.#spaceStopped = true;
      if (!event.repeat) this.stop();
    } else if (!modified && steers(event.code) && !isTyped(event.target)) {
      if (driving) event.preventDefault();
      if (event.repeat) return;
      // Recorded even before the page knows that it drives: the state that says so may arrive after
      // the key, and a key that was dropped then would stay dead for as long as it is held. The
      // chair itself decides whose stick counts, and asks for a stick held at take-over to be let go.
      this.#keys = pressed(this.#keys, event.code, performance.now());
      this.look();
    }
  }

  /** Space belongs to the control that has the focus; of a moving chair it is STOP all the same,
   * for the button that was pressed last keeps the focus, and Ctrl or Alt may be latched. What is
   * typed stays typed. */
  #stops(target: EventTarget | null, modified: boolean): boolean {
    return isMoving(this.chair.state) ? !isTyped(target) : !modified && !isControl(target);
  }

  #keyUp(event: KeyboardEvent): void {
    this.scanner.keyUp(event);
    if (event.code === "Space" && this.#spaceStopped) event.preventDefault(); // else it clicks
    if (event.code === "Space") this.#spaceStopped = false;
    if (!this.#keys.has(event.code)) return;
    this.#keys = released(this.#keys, event.code);
    this.look();
  }
}

function isSame(a: Steering, b: Steering): boolean {
  return (
    a.device === b.device &&
    a.at.forward === b.at.forward &&
    a.at.left === b.at.left &&
    a.waiting.join() === b.waiting.join()
  );
}

function heard(name: "keydown" | "keyup", act: (event: KeyboardEvent) => void): () => void {
  window.addEventListener(name, act, { capture: true });
  return () => window.removeEventListener(name, act, { capture: true });
}
