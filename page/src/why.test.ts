import { expect, it } from "vitest";
import { withReason, type PastReason } from "./why.svelte";

it("remembers what held the chair, the newest first and each once, for three minutes", () => {
  let told: readonly PastReason[] = [];
  told = withReason(told, "A person is crossing.", 0);
  told = withReason(told, "", 1_000);
  expect(told).toEqual([{ words: "A person is crossing.", until: 0 }]);
  told = withReason(told, "A door is shut.", 2_000);
  told = withReason(told, "A person is crossing.", 3_000);
  expect(told.map(({ words }) => words)).toEqual(["A person is crossing.", "A door is shut."]);
  expect(told[0]!.until).toBe(3_000);
  expect(withReason(told, "", 182_500)).toEqual([{ words: "A person is crossing.", until: 3_000 }]);
  for (const words of ["1", "2", "3", "4", "5"]) told = withReason(told, words, 4_000);
  expect(told.map(({ words }) => words)).toEqual(["5", "4", "3", "2"]);
});
