import { afterEach, describe, expect, it, vi } from "vitest";
import { ask, reloaded, reloadOnce, tokenOfLink } from "./server";

afterEach(() => vi.unstubAllGlobals());

describe("server", () => {
  it("says that nobody answers", async () => {
    vi.stubGlobal("fetch", () => Promise.reject(new Error("no")));
    expect(await ask("GET", "/api/me")).toEqual({
      ok: false, status: 0, text: "The server does not respond.",
    });
  });

  it("is asked once by itself for a page of its own version, and again only after that helped", () => {
    const reload = vi.fn();
    const window = { location: { reload } as unknown as Location, sessionStorage };
    expect([reloadOnce(window), reloadOnce(window)]).toEqual([true, false]);
    reloaded(window);
    expect(reloadOnce(window)).toBe(true);
    expect(reload).toHaveBeenCalledTimes(2);
    reloaded(window);
  });

  it("takes the token out of a link, and the address forgets it", () => {
    history.replaceState(null, "", "/therapist#token=a-b_c");
    expect(tokenOfLink(window)).toBe("a-b_c");
    expect(location.hash).toBe("");
    expect(tokenOfLink(window)).toBeNull();
  });
});
