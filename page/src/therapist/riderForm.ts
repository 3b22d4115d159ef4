// Form of a rider: its start values, and what is wrong with them.

import { t } from "../i18n/text.svelte";
import { fault, LIMITS, RIDER } from "./limits";
import type { Goal, RiderDraft } from "./riders.svelte";

export const MOST_NAME = 80;
export const MOST_NOTES = 2000;
export const MOST_GOAL = 120;
export const MOST_GOALS = 8;

/** Why a text is too long; empty: it is not. */
export function tooLong(text: string, most: number): string {
  const n = [...text].length;
  return n > most ? t("rider.form.long", { most, n }) : "";
}

export function nameFault(name: string, others: readonly string[]): string {
  if (!/[^\p{C}\p{Z}]/u.test(name)) return t("rider.form.nameMissing");
  if (others.some((other) => plain(other) === plain(name))) return t("rider.form.nameTaken");
  return tooLong(name.trim(), MOST_NAME);
}

export function goalFault(goal: Goal): string {
  if (goal.kind !== "words" && !(Number.isInteger(goal.target) && goal.target >= 1 && goal.target <= 1000)) {
    return t("rider.form.goalNumber");
  }
  if (goal.kind === "words" && goal.text.trim() === "") return t("rider.form.goalWords");
  return tooLong(goal.text, MOST_GOAL);
}

/** True if the server would take the form. */
export function isWhole(draft: RiderDraft, others: readonly string[]): boolean {
  const { limits, settings } = draft.preset;
  return (
    nameFault(draft.name, others) === "" &&
    tooLong(draft.notes, MOST_NOTES) === "" &&
    draft.goals.every((goal) => goalFault(goal) === "") &&
    LIMITS.every((q) => fault(q, limits[q.name]) === "") &&
    RIDER.every((q) => fault(q, settings[q.name]) === "")
  );
}

/** A name without what a reader would not tell apart. */
function plain(name: string): string {
  return name.normalize("NFKC").replace(/\s/g, "").toLowerCase();
}
