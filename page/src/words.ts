// Texts of the page.

import type { RideEnded, WishPreview, ChairState } from "./messages";

export type Mode = ChairState["mode"];
export type Pace = ChairState["pace"];

export const MODES: Readonly<Record<Mode, { name: string; about: string }>> = {
  shared: { name: "Shared", about: "The chair follows the route; your steering bends it." },
  autonomous: { name: "Autonomous", about: "The chair drives the route by itself." },
  assisted: { name: "Assisted", about: "You steer; the chair helps round people and things. Release the stick and it stops." },
  stop_only: { name: "Stop only", about: "You steer; the chair only slows and stops before people and walls." },
  manual: { name: "Manual", about: "Only you steer. The chair does not stop by itself: it can collide." },
};

export const PACES: Readonly<Record<Pace, string>> = {
  slow: "Slow",
  normal: "Normal",
  brisk: "Brisk",
};

export interface Readiness {
  readonly text: string;
  /** Message that the button sends; null: something else must be done first. */
  readonly action: "take_control" | "resume" | null;
  readonly label: string;
}

/** Next step of the driver before the chair moves. */
export function readiness(
  state: Pick<ChairState, "link" | "driver" | "goal" | "arrived" | "reason"> | null,
  driving: boolean,
  trouble = "",
): Readiness {
  if (!state) return { text: "Not connected to the chair.", action: null, label: "Go on" };
  if (!state.driver) return { text: "No driver.", action: "take_control", label: "Take control" };
  if (!driving) return { text: "Another screen drives.", action: "take_control", label: "Take over" };
  switch (state.link) {
    case "stick_held":
      return { text: "Stopped. Release the stick.", action: null, label: "Go on" };
    case "centre_stick":
      return { text: "Release the stick first.", action: null, label: "Go on" };
    case "confirm":
      return { text: "Stopped. Tap “Go on” when you are ready.", action: "resume", label: "Go on" };
    case "no_heartbeat":
    case "no_driver":
      return { text: "Connection to this screen lost.", action: null, label: "Go on" };
    case "ready":
      return under(state, trouble);
  }
}

function under(state: Pick<ChairState, "goal" | "arrived" | "reason">, trouble: string): Readiness {
  const label = "Ready";
  if (state.reason?.code === "starting") {
    return { text: "Starting. This takes a while.", action: null, label: "Not ready yet" };
  }
  if (state.arrived) return { text: "You have arrived.", action: null, label };
  if (!state.goal) return { text: "Steer, or choose a destination.", action: null, label };
  const name = state.goal.name || "the selected point";
  const text = trouble ? `No route to ${name}. Choose another destination.` : `On the way to ${name}.`;
  return { text, action: null, label };
}

/** Motion of the chair in words. */
export function movement({ speed, turn_rate }: Pick<ChairState, "speed" | "turn_rate">): string {
  if (Math.abs(speed) >= 0.05) return `${speed < 0 ? "reverse, " : ""}${Math.abs(speed).toFixed(1)} m/s`;
  return Math.abs(turn_rate) >= 0.05 ? "turning" : "stopped";
}

/** A ride that was left after less than this is not asked about, m (assumed). */
const SOME_WAY = 2;

/** True if a finished ride is worth a rating. */
export function memorable(ended: Pick<RideEnded, "outcome" | "length">): boolean {
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

export function price(preview: Pick<WishPreview, "extra_length" | "length">): string {
  return `${detour(preview.extra_length)}, ${metres(preview.length)} in total`;
}

export function minutes(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
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
