// All texts in the rider's language: looked up by key, with numbers and dates as that language writes them.

import { de } from "./de";
import { en, type Key } from "./en";

export type { Key } from "./en";
export const LANGUAGES = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof LANGUAGES;
export type Values = Readonly<Record<string, string | number>>;

const CATALOGUES: Readonly<Record<Language, Readonly<Record<Key, string>>>> = { en, de };
const KEPT = "cohelm.language";

/** The kept language, else the device's, else English. */
export function preferred(kept: string | null, device: string): Language {
  const wanted = kept ?? device.slice(0, 2).toLowerCase();
  return wanted === "de" || wanted === "en" ? wanted : "en";
}

function kept(): string | null {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return null;
  }
}

let language = $state<Language>(preferred(kept(), globalThis.navigator?.language ?? ""));

export function languageNow(): Language {
  return language;
}

/** Puts the language on the page, for screen readers and hyphenation. */
export function applyLanguage(): void {
  document.documentElement.lang = language;
}

export function chooseLanguage(chosen: Language): void {
  language = chosen;
  applyLanguage();
  try {
    localStorage.setItem(KEPT, chosen);
  } catch {
    // A device that keeps nothing: it holds until the page is closed.
  }
}

/** The text of a key; `{name}` in it becomes a value. */
export function t(key: Key, values: Values = {}): string {
  return CATALOGUES[language][key].replace(/\{(\w+)\}/g, (whole, name: string) => {
    const value = values[name];
    if (value === undefined) return whole;
    return typeof value === "number" ? num(value, 0) : value;
  });
}

/** One of two texts, by the number that both may contain as `{n}`. */
export function plural(one: Key, many: Key, n: number): string {
  return t(n === 1 ? one : many, { n });
}

/** A number with so many digits after the point or comma. */
export function num(value: number, digits: number): string {
  return value.toLocaleString(language, { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

export function isKey(key: string): key is Key {
  return key in en;
}

/** Text that the chair sent in English, in the rider's language if it is one of the catalogue's. */
export function serverText(text: string): string {
  if (language === "en" || !text) return text;
  const whole = sentence(text);
  const key = known.get(whole);
  if (key) return t(key);
  for (const [pattern, key] of patterns) {
    const found = pattern.exec(whole);
    if (found) return t(key, translated(found.groups ?? {}));
  }
  // Two sentences in one, as a reason and what to do.
  const parts = text.split(/(?<=[.!?"”]) (?=\S)/);
  if (parts.length > 1) return parts.map((part) => serverText(part)).join(" ");
  return text;
}

/** Words of the server with a large first letter and a stop: some of them are parts of a sentence. */
export function sentence(text: string): string {
  const end = /[.!?"”]$/.test(text) ? "" : ".";
  return text.charAt(0).toUpperCase() + text.slice(1) + end;
}

/** The values in a text; they may be texts of the catalogue themselves, as the reason of a failure. */
function translated(values: Readonly<Record<string, string>>): Values {
  return Object.fromEntries(Object.entries(values).map(([name, value]) => [name, serverText(value)]));
}

const sent = (Object.keys(en) as Key[]).filter((key) => /^(reason|offer|notice|refused|unstored)\./.test(key));
const known = new Map<string, Key>(sent.map((key) => [sentence(en[key]), key]));
/** A value does not reach beyond the end of its sentence. */
const VALUE = "(?:(?!\\. ).)+?";
const patterns = sent
  .filter((key) => en[key].includes("{"))
  .map((key): [RegExp, Key] => {
    const escaped = sentence(en[key]).replace(/[.*+?^$()[\]\\|]/g, "\\$&");
    return [new RegExp(`^${escaped.replace(/\{(\w+)\}/g, `(?<$1>${VALUE})`)}$`), key];
  });
