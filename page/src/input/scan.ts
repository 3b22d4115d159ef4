import { t } from "../i18n/text.svelte";

/** Something that a switch can choose; one with `items` opens them. */
export interface Choice {
  readonly key: string;
  readonly label: string;
  readonly items?: readonly Choice[];
}

/** State of the highlight. */
export interface Scan {
  /** The groups that are open, the outer one first. */
  readonly path: readonly string[];
  /** Highlighted item; null: the scan pauses until a switch is pressed. */
  readonly lit: string | null;
  /** From when on it is lit, ms; later than now after a choice, which is a pause. */
  readonly since: number;
  /** Number of rounds without a selection. */
  readonly rounds: number;
}

/** One-switch scanning: the highlight moves by itself after this time, ms. */
export interface Pace {
  readonly dwell: number;
}

export const RESTING: Scan = { path: [], lit: null, since: 0, rounds: 0 };
/** The last choice of an open group. */
export const BACK: Choice = {
  key: "back",
  get label() {
    return t("scan.back");
  },
};
/** After so many rounds without a choice a group closes, and the whole scan rests (assumed). */
const GROUP_ROUNDS = 2;
const ROUNDS = 5;

/** Items of the open group, or all if it is gone. */
export function open(scan: Scan, all: readonly Choice[]): readonly Choice[] {
  let choices = all;
  for (const key of scan.path) {
    const items = find(choices, key)?.items;
    if (!items?.length) return all;
    choices = items;
  }
  return choices === all ? all : [...choices, BACK];
}

/** The choice that is lit. */
export function litOf(scan: Scan, all: readonly Choice[]): Choice | null {
  if (scan.lit === null) return null;
  const choices = open(scan, all);
  return find(choices, scan.lit) ?? choices[0] ?? null;
}

/** From the first choice; `pause` (ms) later where something was just chosen. */
export function begun(all: readonly Choice[], now: number, pause = 0): Scan {
  return { path: [], lit: all[0]?.key ?? null, since: now + pause, rounds: 0 };
}

/** Time goes by: with one switch the light wanders. */
export function ticked(scan: Scan, all: readonly Choice[], pace: Pace, now: number): Scan {
  if (scan.lit === null || now - scan.since < pace.dwell) return scan;
  return moved(scan, all, now);
}

/** To the next choice; with two switches the first one does that. */
export function stepped(scan: Scan, all: readonly Choice[], now: number): Scan {
  return scan.lit === null ? begun(all, now) : { ...moved(scan, all, now), rounds: 0 };
}

/** The lit one is taken: a group opens or closes; anything else is to be done by the caller. */
export function selected(
  scan: Scan,
  all: readonly Choice[],
  now: number,
  pause: number,
): { readonly scan: Scan; readonly chosen: Choice | null } {
  const choice = litOf(scan, all);
  if (!choice) return { scan: begun(all, now), chosen: null };
  const path = open(scan, all) === all ? [] : scan.path;
  const goes = (to: readonly string[]) => inside(to, all, now + pause);
  if (choice.key === BACK.key) return { scan: goes(path.slice(0, -1)), chosen: null };
  if (choice.items) return { scan: goes([...path, choice.key]), chosen: null };
  return { scan: begun(all, now, pause), chosen: choice };
}

function inside(path: readonly string[], all: readonly Choice[], since: number): Scan {
  const scan = { path, lit: null, since, rounds: 0 };
  return { ...scan, lit: open(scan, all)[0]?.key ?? null };
}

function moved(scan: Scan, all: readonly Choice[], now: number): Scan {
  const choices = open(scan, all);
  const at = choices.findIndex((choice) => choice.key === scan.lit);
  const next = choices[at + 1];
  if (next) return { ...scan, lit: next.key, since: now };
  const rounds = at < 0 ? scan.rounds : scan.rounds + 1;
  if (choices !== all && rounds >= GROUP_ROUNDS) return begun(all, now);
  if (rounds >= ROUNDS) return RESTING;
  return { ...scan, lit: choices[0]?.key ?? null, since: now, rounds };
}

function find(choices: readonly Choice[], key: string): Choice | undefined {
  return choices.find((choice) => choice.key === key);
}
