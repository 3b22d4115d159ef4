import { t } from "../i18n/text.svelte";
import type { Choice } from "./scan";

/** A choice and what it stands for on the page. */
export interface Reached extends Choice {
  /** Highlighted elements; for a single item the one that is clicked. */
  readonly elements: readonly HTMLElement[];
  readonly items?: readonly Reached[];
}

/** A longer group is split in rows of no more than this: 30 places in 5 + 6 steps, not in 30. */
const ROW = 6;
const RANK: Readonly<Record<string, number>> = { first: 0, drive: 1, last: 3 };
const keys = new WeakMap<Element, string>();
let made = 0;

/** Items that switches can reach on the page, in highlighting order.
 *
 * Elements with `data-scan`, those in one `data-scan-group` together. `data-scan="first"` comes
 * before `"drive"`, and that before the rest. What is disabled is not reached, unless it is only busy.
 * Behind an open dialog only STOP is. */
export function reach(document: Document): Reached[] {
  const dialogs = document.querySelectorAll<HTMLElement>("dialog[open]");
  const root = dialogs[dialogs.length - 1] ?? document;
  const found = new Map<Element, Reached & { items?: Reached[] }>();
  const outside = root === document ? [] : document.querySelectorAll<HTMLElement>("[data-stop][data-scan]");
  for (const element of [...root.querySelectorAll<HTMLElement>("[data-scan]"), ...outside]) {
    if (!isThere(element)) continue;
    const choice = { key: keyOf(element), label: labelOf(element), elements: [element] };
    const group = element.closest<HTMLElement>("[data-scan-group]");
    const of = group && root.contains(group) ? group : null;
    if (!of) found.set(element, choice);
    else if (found.has(of)) found.get(of)?.items?.push(choice);
    else found.set(of, { key: keyOf(of), label: labelOf(of), elements: [of], items: [choice] });
  }
  return [...found.values()].map(arranged).sort((a, b) => rank(a) - rank(b));
}

/** A group of one is not worth a press of its own, and a long one is worth one more. */
function arranged(choice: Reached): Reached {
  const { items } = choice;
  if (!items) return choice;
  if (items.length === 1) return items[0] ?? choice;
  return items.length > ROW + 1 ? { ...choice, items: rows(items) } : choice;
}

function rows(items: readonly Reached[]): Reached[] {
  const count = Math.ceil(items.length / ROW);
  const cut = (n: number) => Math.round((n * items.length) / count);
  return Array.from({ length: count }, (_, n) => row(items.slice(cut(n), cut(n + 1))));
}

function row(items: readonly Reached[]): Reached {
  const [first, last] = [items[0]!, items[items.length - 1]!];
  const elements = items.flatMap((each) => each.elements);
  return { key: `${first.key} to ${last.key}`, label: t("scan.from", { first: first.label, last: last.label }), elements, items };
}

function rank(choice: Reached): number {
  return RANK[choice.elements[0]?.dataset["scan"] ?? ""] ?? 2;
}

function isThere(element: HTMLElement): boolean {
  const shown = element.checkVisibility?.({ visibilityProperty: true }) ?? !element.hidden;
  return shown && !element.matches(":disabled, [aria-disabled=true]:not([aria-busy=true])");
}

function labelOf(element: HTMLElement): string {
  const named = element.dataset["scanGroup"] ?? element.getAttribute("aria-label") ?? element.getAttribute("title");
  return (named || element.textContent || "").replace(/\s+/g, " ").trim();
}

function keyOf(element: Element): string {
  const kept = keys.get(element) ?? `scan-${made++}`;
  keys.set(element, kept);
  return kept;
}
