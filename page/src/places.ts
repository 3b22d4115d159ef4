// Places by kind, and those that this rider uses: recent ones and favourites, kept on this device.

import type { Key } from "./i18n/text.svelte";
import type { PlaceInfo } from "./messages";

export interface Named {
  readonly name: string;
}

export interface Group<P extends Named> {
  readonly title: Key;
  readonly places: readonly P[];
}

/** What a name says about its kind, in English and German maps; the first that fits counts. */
const KINDS: readonly (readonly [Key, RegExp])[] = [
  ["places.care", /\b(pharmacy|laborator|lab\b|x-?ray|radiology|surgery|clinic|therapy|physio|emergency|nurse|doctor|consult|treatment|examination|imaging|theatre|icu)/i],
  ["places.wards", /\b(ward|station|bedroom|patient|zimmer)\b/i],
  ["places.toilets", /\b(wc|toilet|restroom|bath|lavatory|washroom|toilette|bad)/i],
  ["places.food", /\b(cafe|café|cafeteria|canteen|kitchen|restaurant|dining|kiosk|vending|kantine|küche)/i],
  ["places.ways", /\b(entrance|exit|lift|elevator|stairs|lobby|reception|waiting|parking|eingang|ausgang|aufzug)/i],
];
/** Order in which the kinds are shown. */
export const ORDER: readonly Key[] = [
  "places.wards", "places.toilets", "places.food", "places.care", "places.ways", "places.other",
];
/** Ways between rooms: they stay as white as the map. */
const PASSAGES = /\b(corridor|passage|hallway|hall|niche|aisle|flur|gang|nische)\b/i;
const MOST_RECENT = 4;
const RECENT = "cohelm.recent";
const FAVOURITES = "cohelm.favourites";

/** Places by their names in a language, where the map has them. */
export function inLanguage(places: readonly PlaceInfo[], language: string): PlaceInfo[] {
  return places.map((each) => ({ ...each, name: each.names?.[language] ?? each.name }));
}

/** Every place once, by kind; kinds without a place are left out. */
export function grouped<P extends Named>(places: readonly P[]): Group<P>[] {
  const left = new Set(places);
  const groups = KINDS.map(([title, pattern]): Group<P> => {
    const fitting = [...left].filter(({ name }) => pattern.test(name));
    for (const each of fitting) left.delete(each);
    return { title, places: fitting };
  });
  return [...groups, { title: "places.other" as Key, places: [...left] }]
    .filter((each) => each.places.length > 0)
    .sort((a, b) => ORDER.indexOf(a.title) - ORDER.indexOf(b.title));
}

/** Kind of a room by its name; null: a passage. */
export function kindOf(name: string): Key | null {
  if (PASSAGES.test(name)) return null;
  return KINDS.find(([, pattern]) => pattern.test(name))?.[0] ?? "places.other";
}

/** A name moves to the front of the recent ones. */
export function recentAfter(names: readonly string[], name: string): string[] {
  return [name, ...names.filter((each) => each !== name)].slice(0, MOST_RECENT);
}

export function toggled(names: readonly string[], name: string): string[] {
  return names.includes(name) ? names.filter((each) => each !== name) : [...names, name];
}

export function recent(): readonly string[] {
  return stored(RECENT);
}

export function remember(name: string): void {
  keep(RECENT, recentAfter(recent(), name));
}

export function favourites(): readonly string[] {
  return stored(FAVOURITES);
}

export function toggleFavourite(name: string): readonly string[] {
  const now = toggled(favourites(), name);
  keep(FAVOURITES, now);
  return now;
}

function stored(key: string): readonly string[] {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(key) ?? "[]");
    return Array.isArray(kept) ? kept.filter((each): each is string => typeof each === "string") : [];
  } catch {
    return [];
  }
}

function keep(key: string, names: readonly string[]): void {
  try {
    localStorage.setItem(key, JSON.stringify(names));
  } catch {
    // A device that keeps nothing offers none the next time.
  }
}
