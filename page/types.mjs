// Writes src/messages.ts from the schema of the messages, so that the page and the chair cannot
// come to speak differently without the compiler saying so.
import { readFile, writeFile } from "node:fs/promises";
import { compile } from "json-schema-to-typescript";

const schema = new URL("../src/cohelm/web/messages.schema.json", import.meta.url);
const types = new URL("src/messages.ts", import.meta.url);

const made = await compile(JSON.parse(await readFile(schema, "utf8")), "Messages", {
  bannerComment: "// Made by types.mjs from ../src/cohelm/web/messages.schema.json; do not edit.",
  maxItems: -1,
});
await writeFile(
  types,
  `${made}
export type FromPage = Messages["fromPage"];
export type ToPage = Messages["toPage"];
`,
);
