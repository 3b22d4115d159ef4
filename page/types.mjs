// Writes src/messages.ts from the schema of the messages and src/measures.ts from the table of
// measures, so that page and chair cannot diverge without the compiler saying so.
import { readFile, writeFile } from "node:fs/promises";
import { compile } from "json-schema-to-typescript";

const schema = new URL("../src/cohelm/web/messages.schema.json", import.meta.url);
const types = new URL("src/messages.ts", import.meta.url);

/** Without the least length of lists, which TypeScript would have everybody prove. */
function withoutLengths(part) {
  if (part === null || typeof part !== "object") return part;
  if (Array.isArray(part)) return part.map(withoutLengths);
  const entries = Object.entries(part).map(([key, value]) => [key, withoutLengths(value)]);
  const list = part.type === "array" && !Array.isArray(part.items);
  return Object.fromEntries(entries.filter(([key]) => !(list && key === "minItems")));
}

const messages = JSON.parse(await readFile(schema, "utf8"));
const made = await compile(withoutLengths(messages), "Messages", {
  bannerComment: "// Made by types.mjs from ../src/cohelm/web/messages.schema.json; do not edit.",
  maxItems: -1,
});
// Points and poses are values: nobody changes them in place.
const text = made.replace(/\[(number(?:, number)+)\]/g, "(readonly [$1])");
await writeFile(
  types,
  `${text}
/** Of the messages. */
export const VERSION: number = ${messages.definitions.Welcome.properties.version.default};
export type FromPage = Messages["fromPage"];
export type ToPage = Messages["toPage"];
`,
);

const table = new URL("../src/cohelm/web/measures.json", import.meta.url);
const measures = JSON.parse(await readFile(table, "utf8"));
const rows = measures.map(({ name, label, unit, digits }) => [name, { label, unit, digits }]);
await writeFile(
  new URL("src/measures.ts", import.meta.url),
  `// Made by types.mjs from ../src/cohelm/web/measures.json; do not edit.
export const MEASURES = ${JSON.stringify(Object.fromEntries(rows), null, 2)} as const;
export type MeasureName = keyof typeof MEASURES;
`,
);
