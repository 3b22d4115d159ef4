// @vitest-environment node
import { readdirSync, readFileSync } from "node:fs";
import { parse } from "svelte/compiler";
import { describe, expect, it } from "vitest";
import { de } from "./de";
import { en } from "./en";
import { chooseLanguage, num, plural, preferred, serverText, t } from "./text.svelte";

const FIELDS = /\{\w+\}/g;
/** Attributes that people read or hear. */
const READ = new Set(["aria-label", "aria-valuetext", "aria-roledescription", "title", "alt", "placeholder", "label"]);
/** Names and signs that are the same in every language. */
const SAME = /^[\s\d\p{P}\p{S}]*$|^(?:m\/s|m|s|%)$/u;

describe("the catalogues", () => {
  it("have the same keys", () => {
    expect(Object.keys(de).sort()).toEqual(Object.keys(en).sort());
  });

  it("fill the same fields, and leave no text out", () => {
    for (const key of Object.keys(en) as (keyof typeof en)[]) {
      expect([key, (de[key].match(FIELDS) ?? []).sort()]).toEqual([key, (en[key].match(FIELDS) ?? []).sort()]);
      expect([key, de[key].trim() !== "", en[key].trim() !== ""]).toEqual([key, true, true]);
    }
  });
});

const FILES = readdirSync("src", { recursive: true, encoding: "utf8" }).map((file) => `src/${file}`);

interface Node {
  readonly type: string;
  readonly name?: string;
  readonly data?: string;
  readonly [key: string]: unknown;
}

/** Words that stand in a component itself: text nodes, and attributes that are read out. */
function written(node: unknown, attribute = ""): string[] {
  if (Array.isArray(node)) return node.flatMap((each) => written(each, attribute));
  if (node === null || typeof node !== "object") return [];
  const { type, name, data } = node as Node;
  if (type === "Text") return SAME.test(data ?? "") || (attribute && !READ.has(attribute)) ? [] : [data!.trim()];
  const inside = type === "Attribute" ? (name ?? "") : attribute;
  if (type === "StyleDirective" || type === "ClassDirective") return [];
  return Object.entries(node as Node)
    .filter(([key]) => !["parent", "css", "instance", "module", "metadata"].includes(key))
    .flatMap(([, value]) => written(value, inside));
}

describe("no text bypasses them", () => {
  const components = FILES.filter((file) => file.endsWith(".svelte"));

  it("in any component", () => {
    expect(components.length).toBeGreaterThan(25);
    const found = components.flatMap((file) => {
      const words = written(parse(readFileSync(file, "utf8"), { modern: true }).fragment);
      return words.map((text) => `${file}: ${text}`);
    });
    expect(found).toEqual([]);
  });

  it("in any script: what looks like a sentence is in a catalogue", () => {
    const scripts = FILES.filter(
      (file) => /\.(ts|svelte)$/.test(file) && !/test\.ts$|i18n|messages\.ts|measures\.ts/.test(file),
    );
    const found = scripts.flatMap((file) => {
      const code = readFileSync(file, "utf8").replace(/<style>[\s\S]*<\/style>|generics="[^"]*"/g, "").replace(/\/\*[\s\S]*?\*\/|\/\/.*|<!--[\s\S]*?-->/g, "");
      const said = [...code.matchAll(/["`]([A-Z][a-z’']+ [a-z][^"`]*?[a-z.?!…])["`]/g)].map((each) => each[1]);
      return said.map((text) => `${file}: ${text}`);
    });
    expect(found).toEqual([]);
  });
});

describe("a text", () => {
  it("has its values, by the language's own numbers", () => {
    chooseLanguageOf("de");
    expect(num(1234.5, 1)).toBe("1.234,5");
    expect(t("trip.via", { name: "Labor" })).toBe("Über Labor");
    expect(plural("places.one", "places.many", 1)).toBe("1 Ort");
    chooseLanguageOf("en");
    expect(num(1234.5, 1)).toBe("1,234.5");
    expect(plural("places.one", "places.many", 3)).toBe("3 places");
  });

  it("of the chair is told in the rider's language, also in two sentences and with a number", () => {
    chooseLanguageOf("de");
    expect(serverText("You stopped the chair.")).toBe("Sie haben den Rollstuhl angehalten.");
    expect(serverText('You stopped the chair. Tap "Go on".')).toBe("Sie haben den Rollstuhl angehalten. Tippen Sie auf „Weiter“.");
    expect(serverText("You have come 6 m closer")).toBe("Sie sind 6 m näher gekommen");
    expect(serverText("Something new.")).toBe("Something new.");
    expect(serverText("No more than 60 people can be in the simulation.")).toBe("In der Simulation können höchstens 60 Personen sein.");
    expect(serverText("the request is too large")).toBe("Die Anfrage ist zu groß.");
  });

  it("of the chair has values that are texts themselves, each in its own sentence", () => {
    chooseLanguageOf("de");
    expect(serverText("The speed can be loosened only while the chair stands. The acceleration can be loosened only while the chair stands.")).toBe(
      "Die Geschwindigkeit kann nur gelockert werden, während der Rollstuhl steht. Die Beschleunigung kann nur gelockert werden, während der Rollstuhl steht.",
    );
    expect(serverText("Rides are not stored: it cannot be written (No space left on device). The audit log is not stored: it cannot be read.")).toBe(
      "Fahrten werden nicht gespeichert: kann nicht geschrieben werden (Kein Speicherplatz mehr). Das Protokoll wird nicht gespeichert: ist nicht zu lesen.",
    );
    chooseLanguageOf("en");
    expect(serverText("You stopped the chair.")).toBe("You stopped the chair.");
  });

  it("is in the kept language, else in the device's, else in English", () => {
    expect(preferred("en", "de-DE")).toBe("en");
    expect(preferred(null, "de-AT")).toBe("de");
    expect(preferred(null, "fr-FR")).toBe("en");
  });
});

/** Without a document there is nothing to mark. */
function chooseLanguageOf(language: "en" | "de"): void {
  Object.assign(globalThis, { document: { documentElement: { lang: "" } } });
  chooseLanguage(language);
}
