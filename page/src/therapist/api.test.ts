import { afterEach, describe, expect, it, vi } from "vitest";
import { api, fileOf } from "./api";

afterEach(() => vi.unstubAllGlobals());

function server(status: number, said: unknown): ReturnType<typeof vi.fn> {
  const body = said === undefined ? null : JSON.stringify(said);
  const fetched = vi.fn(async () => new Response(body, { status }));
  vi.stubGlobal("fetch", fetched);
  return fetched;
}

describe("api", () => {
  it("sends what is changed as JSON and gives back what is in force", async () => {
    const now = { max_speed: 0.5, max_acceleration: 0.4, min_distance: 0.6 };
    const fetched = server(200, now);
    expect(await api.limits(now)).toEqual({ ok: true, value: now });
    expect(fetched).toHaveBeenCalledWith("/api/limits", {
      method: "PUT",
      credentials: "same-origin",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(now),
    });
  });

  it("gives a refusal back in the server's words, as a sentence", async () => {
    server(409, { code: "limits_loosened", text: "the speed can be loosened only while the chair stands" });
    expect(await api.sessions()).toEqual({
      ok: false,
      status: 409,
      text: "The speed can be loosened only while the chair stands.",
    });
    server(500, "odd");
    expect(await api.audit()).toMatchObject({ ok: false, text: "The server refused this (500)." });
  });

  it("takes an empty answer", async () => {
    server(200, undefined);
    expect(await api.signOut()).toEqual({ ok: true, value: null });
  });

  it("names files, whatever the id", () => {
    expect(fileOf("20260131-142530-r1", "png")).toBe("/api/sessions/20260131-142530-r1.png");
    expect(fileOf("../a?b", "csv")).toBe("/api/sessions/..%2Fa%3Fb.csv");
  });
});
