import { afterEach, describe, expect, it, vi } from "vitest";
import { ask, tokenOfLink } from "./server";

afterEach(() => vi.unstubAllGlobals());

describe("server", () => {
  it("says that nobody answers", async () => {
    vi.stubGlobal("fetch", () => Promise.reject(new Error("no")));
    expect(await ask("GET", "/api/me")).toEqual({
      ok: false, status: 0, text: "The chair’s server does not answer.",
    });
  });

  it("takes the token out of a link, and the address forgets it", () => {
    history.replaceState(null, "", "/therapist#token=a-b_c");
    expect(tokenOfLink(window)).toBe("a-b_c");
    expect(location.hash).toBe("");
    expect(tokenOfLink(window)).toBeNull();
  });
});
