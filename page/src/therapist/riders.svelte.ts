// Riders as the server knows them, for all cards of the therapist's view.

import { t } from "../i18n/text.svelte";
import type { Limits, RiderSettings } from "../messages";
import { ask, type Answer } from "../server";
import type { Mode, Pace } from "../words";

export interface Goal {
  kind: "arrivals" | "unaided" | "words";
  target: number;
  text: string;
  done: boolean;
}

export interface Preset {
  limits: Limits;
  settings: RiderSettings;
  mode: Mode;
  pace: Pace;
}

export interface RiderDraft {
  name: string;
  notes: string;
  preset: Preset;
  goals: Goal[];
}

export interface RiderRecord extends RiderDraft {
  id: string;
  created: string;
  changed: string;
}

export interface RiderList {
  riders: RiderRecord[];
  damaged: { id: string; problem: string }[];
  /** Id of who rides; empty: nobody was chosen. */
  current: string;
}

export type Quantity = "arrivals" | "stops" | "effort" | "reversals" | "near_passes";
export type Direction = "few" | "unclear" | "rising" | "falling";

export interface SessionProgress {
  session: string;
  started: string;
  scene: string;
  rides: number;
  trips: number;
  arrivals: number;
  unaided: number;
  distance: number;
  mode: Mode | null;
  values: Record<Quantity, number | null>;
}

export interface RiderProgress {
  sessions: SessionProgress[];
  directions: Record<Quantity, Direction>;
  goals: { goal: Goal; reached: number; done: boolean }[];
  min_sessions: number;
}

const at = (id: string): string => `/api/riders/${encodeURIComponent(id)}`;

export const ridersApi = {
  list: () => ask<RiderList>("GET", "/api/riders"),
  create: (draft: RiderDraft) => ask<RiderRecord>("POST", "/api/riders", draft),
  change: (id: string, draft: RiderDraft) => ask<RiderRecord>("PUT", at(id), draft),
  choose: (id: string) => ask<RiderList>("PUT", "/api/riders/current", { rider: id }),
  remove: (id: string) => ask<{ sessions: number; unreadable: number }>("DELETE", at(id)),
  progress: (id: string) => ask<RiderProgress>("GET", `${at(id)}/progress`),
  limits: () => ask<Limits>("GET", "/api/limits"),
  archive: (id: string) => `${at(id)}.zip`,
};

export class Riders {
  /** Null: not known yet. */
  all = $state.raw<RiderList | null>(null);
  /** Why they are not known; empty: they are. */
  trouble = $state("");
  readonly current = $derived(this.all?.riders.find((each) => each.id === this.all?.current) ?? null);

  async load(): Promise<void> {
    this.take(await ridersApi.list());
  }

  take(answer: Answer<RiderList>): void {
    if (answer.ok) this.all = answer.value;
    this.trouble = answer.ok ? "" : answer.text;
  }

  /** Name of a rider; empty for nobody. */
  name(id: string): string {
    if (!id) return "";
    return this.all?.riders.find((each) => each.id === id)?.name ?? t("riders.unknown", { id });
  }
}

export const riders = new Riders();
