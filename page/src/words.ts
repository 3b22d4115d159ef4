// What the page says, in plain words.

import type { Ended, Preview, State } from "./messages";

export type Mode = State["mode"];
export type Pace = State["pace"];

export const MODES: Readonly<Record<Mode, { name: string; about: string }>> = {
  shared: { name: "Shared", about: "The chair follows its way; your hand bends it." },
  autonomous: { name: "Chair alone", about: "The chair follows its way by itself." },
  assisted: { name: "With help", about: "You steer; the chair keeps you from bumping into anything." },
  manual: { name: "By hand", about: "You alone steer. Nothing holds the chair back: it can collide." },
};

export const PACES: Readonly<Record<Pace, string>> = {
  slow: "Slow",
  normal: "Normal",
  brisk: "Brisk",
};

export interface Readiness {
  readonly text: string;
  /** What may be pressed; null: there is something else to do first. */
  readonly action: "take" | "resume" | null;
  readonly label: string;
}

/** What the driver has to do before the chair moves. */
export function readiness(
  state: Pick<State, "link" | "driver" | "goal" | "arrived" | "why"> | null,
  driving: boolean,
  trouble = "",
): Readiness {
  if (!state) return { text: "Not connected to the chair.", action: null, label: "Go on" };
  if (!state.driver) return { text: "Nobody drives.", action: "take", label: "Take control" };
  if (!driving) return { text: "Another page drives.", action: "take", label: "Take over" };
  switch (state.link) {
    case "stopped":
      return { text: "Stopped. Let the stick go.", action: null, label: "Go on" };
    case "centre":
      return { text: "Let the stick go first.", action: null, label: "Go on" };
    case "confirm":
      return { text: "Standing. Press “Go on” when you are ready.", action: "resume", label: "Go on" };
    case "silent":
    case "nobody":
      return { text: "The chair does not hear this page.", action: null, label: "Go on" };
    case "ready":
      return under(state, trouble);
  }
}

function under(state: Pick<State, "goal" | "arrived" | "why">, trouble: string): Readiness {
  const label = "Ready";
  if (state.why?.code === "getting_ready") {
    return { text: "Getting ready. It takes a while.", action: null, label: "Not ready yet" };
  }
  if (state.arrived) return { text: "We have arrived.", action: null, label };
  if (!state.goal) return { text: "Steer, or choose where to go.", action: null, label };
  const name = state.goal.name || "the point you touched";
  const text = trouble ? `No way to ${name}. Choose another place.` : `On the way to ${name}.`;
  return { text, action: null, label };
}

/** What the wheels do, in words. */
export function movement({ speed, turn }: Pick<State, "speed" | "turn">): string {
  if (Math.abs(speed) >= 0.05) return `${speed < 0 ? "back, " : ""}${Math.abs(speed).toFixed(1)} m/s`;
  return Math.abs(turn) >= 0.05 ? "turning" : "standing";
}

/** A ride that was left after less than this is not asked about, m (assumed). */
const SOME_WAY = 2;

/** Whether there is something to say of a ride that is over. */
export function memorable(ended: Pick<Ended, "outcome" | "length">): boolean {
  return ended.outcome === "collision" || ended.length >= SOME_WAY;
}

export function metres(length: number): string {
  return `${length < 9.95 ? length.toFixed(1) : length.toFixed(0)} m`;
}

/** "+4.2 m", or "no detour". */
export function detour(extra: number): string {
  if (Math.abs(extra) < 0.05) return "no detour";
  return extra > 0 ? `+${metres(extra)}` : `−${metres(-extra)}`;
}

export function price(preview: Pick<Preview, "extra" | "length">): string {
  return `${detour(preview.extra)}, ${metres(preview.length)} in all`;
}

export function minutes(seconds: number): string {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}

/** The places whose name has every word of the search; those that begin with it first. */
export function found<P extends { readonly name: string }>(places: readonly P[], search: string): P[] {
  const words = plain(search).split(/\s+/).filter(Boolean);
  const fitting = places.filter(({ name }) => words.every((word) => plain(name).includes(word)));
  const begins = (place: P): number => (plain(place.name).startsWith(plain(search).trim()) ? 0 : 1);
  return fitting.sort((a, b) => begins(a) - begins(b) || a.name.localeCompare(b.name, undefined, { numeric: true }));
}

function plain(text: string): string {
  return text.normalize("NFD").replace(/\p{M}/gu, "").replace(/[’']/g, "'").toLowerCase();
}
