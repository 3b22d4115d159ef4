import type { Heartbeat as HeartbeatMessage } from "../messages";
import type { Device } from "./arbiter";
import { CENTRE, type Deflection } from "./deflection";

/** A beat with nothing left out. */
export type BeatOut = Required<HeartbeatMessage>;

/** Between beats while nothing changes, ms. */
export const STEADY = 100;
/** Least time between two beats with a change, ms: thirty a second; a stick let go does not wait. */
export const QUICKEST = 1000 / 30;
/** A smaller change than this waits for the steady beat, share of full deflection. */
const CHANGE = 0.01;

/** Tells the chair that the page is alive and where its stick is.
 *
 * Steadily ten times a second and soon after every change. It runs on the page's own thread on
 * purpose: a page that hangs falls silent, and the chair stops. */
export class Heartbeat {
  private seq = 0;
  private open = false;
  private visible = true;
  private at: Deflection = CENTRE;
  private device: Device = "none";
  private told: { at: Deflection; device: Device } = { at: CENTRE, device: "none" };
  /** When the last change was told: a steady beat just before a press does not let it wait. */
  private changed = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly send: (beat: BeatOut) => void,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** A new connection: numbers begin anew. */
  connected(): void {
    this.open = true;
    this.seq = 0;
    this.beat();
  }

  disconnected(): void {
    this.open = false;
    clearTimeout(this.timer);
  }

  /** Set the current deflection. */
  put(at: Deflection, device: Device): void {
    this.at = at;
    this.device = device;
    if (!this.open || !this.visible || !this.differs()) return;
    const letGo = at.forward === 0 && at.left === 0;
    const wait = this.changed + QUICKEST - this.now();
    if (letGo || wait <= 0) this.beat();
    else this.arm(wait);
  }

  /** The page is looked at, or no longer: then one last beat says so, and there are no more. */
  present(visible: boolean): void {
    if (visible === this.visible) return;
    this.visible = visible;
    if (!visible) {
      this.at = CENTRE;
      this.device = "none";
    }
    if (this.open) this.beat();
  }

  /** Send a beat before a message that counts only from a page that is heard: after a moment in which
   * the page was busy, a press overtakes the steady beat. */
  assure(): void {
    if (this.open && this.visible) this.beat();
  }

  private beat(): void {
    const { at, device, visible } = this;
    const sent = this.now();
    if (this.differs()) this.changed = sent;
    this.told = { at, device };
    const stick = { forward: at.forward, left: at.left, device };
    this.send({ type: "heartbeat", seq: this.seq++, sent, ...stick, visible });
    if (visible) this.arm(STEADY);
    else clearTimeout(this.timer);
  }

  private arm(wait: number): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.beat(), wait);
  }

  private differs(): boolean {
    const { at, device, told } = this;
    const moved = Math.hypot(at.forward - told.at.forward, at.left - told.at.left);
    const letGo = moved > 0 && at.forward === 0 && at.left === 0;
    return device !== told.device || letGo || moved >= CHANGE;
  }
}
