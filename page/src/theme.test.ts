// @vitest-environment node
import { expect, it } from "vitest";
import { paletteOf } from "./theme";

it("follows the device only where nothing else is chosen", () => {
  expect(paletteOf("auto", { contrast: false, dark: false })).toBe("light");
  expect(paletteOf("auto", { contrast: false, dark: true })).toBe("dark");
  expect(paletteOf("auto", { contrast: true, dark: true })).toBe("contrast");
  expect(paletteOf("light", { contrast: true, dark: true })).toBe("light");
});
