// Search for places that forgives: any language, words of the same meaning, no spaces, one typo.

import { languageNow } from "./i18n/text.svelte";

export interface Searched {
  readonly name: string;
  /** The name in other languages. */
  readonly names?: Readonly<Record<string, string>>;
}

/** Words of one meaning in names and searches, in English and German maps. */
const MEANINGS: readonly (readonly string[])[] = [
  ["lift", "elevator", "aufzug", "fahrstuhl"],
  ["ward", "station"],
  ["wc", "toilet", "restroom", "lavatory", "washroom", "toilette", "klo"],
  ["bathroom", "bath", "bad", "badezimmer"],
  ["cafeteria", "cafe", "canteen", "kantine"],
  ["kitchen", "kuche"],
  ["pharmacy", "apotheke"],
  ["laboratory", "lab", "labor"],
  ["radiology", "xray", "rontgen", "radiologie"],
  ["examination", "untersuchung"],
  ["therapy", "physio", "therapie"],
  ["reception", "empfang", "anmeldung"],
  ["waiting", "warte", "wartebereich", "wartezimmer"],
  ["stairs", "staircase", "treppe"],
  ["corridor", "hallway", "flur", "gang"],
  ["passage", "durchgang"],
  ["entrance", "eingang"],
  ["exit", "ausgang"],
  ["doctor", "arzt"],
  ["nurse", "pflege", "schwestern"],
  ["office", "buro"],
  ["meeting", "besprechung"],
  ["store", "lager"],
  ["laundry", "wascherei"],
  ["north", "nord"],
  ["south", "sud"],
  ["east", "ost"],
  ["room", "zimmer", "raum"],
];
/** A shorter word has no typo: too many others are one letter away. */
const LONG = 4;

/** The places that a search means: by their name; where there is none, by meaning, and only then with one typo. */
export function found<P extends Searched>(places: readonly P[], search: string): P[] {
  const ranked = places.map((place) => [Math.min(...spellings(place).map((name) => rank(name, search))), place] as const);
  const best = Math.max(1, Math.min(...ranked.map(([at]) => at)));
  return ranked
    .filter(([at]) => at <= best && at < Infinity)
    .sort(([a, one], [b, other]) => a - b || one.name.localeCompare(other.name, languageNow(), { numeric: true }))
    .map(([, place]) => place);
}

function spellings({ name, names }: Searched): string[] {
  return [name, ...Object.values(names ?? {})];
}

/** How well a name fits: 0 it begins so, 1 it has every word, 2 by meaning, 3 with one typo; infinite: not at all. */
function rank(name: string, search: string): number {
  const [whole, wanted] = [joined(name), joined(search)];
  if (whole.startsWith(wanted)) return 0;
  const words = wordsOf(search);
  if (whole.includes(wanted) || words.every((word) => whole.includes(word))) return 1;
  const meant = wordsOf(name).flatMap((word) => [word, ...meaning(word)]);
  const same = (word: string, each: string): boolean => each === word || (word.length >= LONG && each.startsWith(word));
  if (words.every((word) => meant.some((each) => same(word, each)))) return 2;
  if (wanted.length < LONG) return Infinity;
  const near = (word: string): boolean => meant.some((each) => same(word, each) || oneTypo(word, each));
  return oneTypo(wanted, whole) || words.every(near) ? 3 : Infinity;
}

function meaning(word: string): readonly string[] {
  return MEANINGS.find((each) => each.includes(word) || each.includes(word.replace(/s$/, ""))) ?? [];
}

/** Words and numbers, without accents: "ward2" has two. */
function wordsOf(text: string): string[] {
  return plain(text).match(/\p{L}+|\p{N}+/gu) ?? [];
}

function joined(text: string): string {
  return plain(text).replace(/[^\p{L}\p{N}]/gu, "");
}

function plain(text: string): string {
  return text.normalize("NFD").replace(/\p{M}/gu, "").replace(/ß/g, "ss").replace(/[’'-]/g, "").toLowerCase();
}

/** True if the beginning of a name is one wrong, missing, additional or swapped letter away; figures are as they are. */
function oneTypo(word: string, name: string): boolean {
  if (word.length < LONG || figures(word) !== figures(name.slice(0, word.length + 1))) return false;
  const k = [...word].findIndex((letter, n) => letter !== name[n]);
  if (k < 0) return true;
  const rest = (of: string, from: number): string => of.slice(from);
  return (
    rest(name, k + 1).startsWith(rest(word, k + 1)) ||
    rest(name, k).startsWith(rest(word, k + 1)) ||
    rest(name, k + 1).startsWith(rest(word, k)) ||
    (word[k] === name[k + 1] && word[k + 1] === name[k] && rest(name, k + 2).startsWith(rest(word, k + 2)))
  );
}

function figures(text: string): string {
  return text.replace(/\P{N}/gu, "");
}
