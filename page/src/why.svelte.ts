// Why the chair stands, or is slow: what is told now, and what was a moment ago.

import { chair } from "./chair.svelte";
import { num, t } from "./i18n/text.svelte";
import { ASKED } from "./reasonDisplay";
import { isSlow, paceOf, slowFor, type Slowness } from "./slowed";
import { reasonNow, standingNow } from "./status";
import { surroundings } from "./surroundings.svelte";
import { nextTurn } from "./turns";
import { causeWords } from "./words";

/** A reason that held or slowed the chair. */
export interface PastReason {
  readonly words: string;
  /** When it was last true, ms. */
  readonly until: number;
}

/** So many are kept, for so long, ms (assumed). */
const MOST = 3;
const KEPT = 180_000;
/** Below this share of its pace a chair that is asked about is slow (assumed): closer to it, nobody asks. */
const SLOWER = 0.75;

/** The reasons of the last minutes, the newest first, with one more that holds now. */
export function withReason(was: readonly PastReason[], words: string, now: number): readonly PastReason[] {
  const kept = was.filter(({ until }) => now - until < KEPT);
  if (!words) return kept;
  return [{ words, until: now }, ...kept.filter((each) => each.words !== words)].slice(0, MOST + 1);
}

class Why {
  /** True while the card is open. */
  open = $state(false);
  /** The newest first. */
  past = $state.raw<readonly PastReason[]>([]);
  now = $state(0);
  /** What holds or slows the chair, in words; empty: nothing does. */
  held = $state("");

  /** What the chair does now, with its reason. */
  readonly present = $derived(standingNow() || this.held || t("why.nothing"));
  /** What was told before, and how long ago, s. */
  readonly before = $derived(
    this.past
      .filter(({ words }) => words !== this.present)
      .slice(0, MOST)
      .map(({ words, until }) => ({ words, ago: Math.max(1, Math.round((this.now - until) / 1_000)) })),
  );
  /** What the rider can do about it, where no button says so; empty: nothing. */
  readonly remedy = $derived(chair.state && !chair.state.driver ? t("why.noDriver") : "");
  /** The speed that is set; empty: it is not known. */
  readonly pace = $derived.by(() => {
    const { state, limits } = chair;
    if (!state) return "";
    const speed = num(paceOf(state.pace, limits?.max_speed ?? Infinity), 1);
    return t("why.pace", { pace: t(`pace.${state.pace}`), speed, tab: t("tab.driving") });
  });

  /** Called ten times a second. */
  look(now: number): void {
    const slow = slowness();
    this.held = reason() || (slow === "some" ? t("why.some") : slow ? t(`why.${slow}`) : "");
    const next = withReason(this.past, slow === "some" ? "" : this.held, now);
    if (next.length > 0 || this.past.length > 0) this.past = next;
    if (this.open) this.now = now;
  }
}

/** The reason on display, or what is close to a chair that sets off; empty: there is none. */
function reason(): string {
  const { close, saying, stands } = surroundings;
  const { state, goal } = chair;
  const { shown } = saying;
  if (shown) return ASKED.has(shown.code) || shown.code === "arrived" ? "" : reasonNow();
  return stands && close && goal && state?.link === "ready" && !state.arrived ? causeWords(close) : "";
}

/** What a driving chair is slower for than its pace; "some": it is, and nobody knows why. */
function slowness(): Slowness | "some" | null {
  const { state, limits, route } = chair;
  const most = limits?.max_speed ?? Infinity;
  if (!state || !isSlow(state, most, SLOWER)) return null;
  const turn = state.remaining === null ? null : nextTurn(route.points, state.remaining);
  return slowFor(state, surroundings.ahead, most, turn?.after ?? null, SLOWER) ?? "some";
}

export const why = new Why();
