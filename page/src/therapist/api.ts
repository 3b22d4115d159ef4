// What the therapist's view asks of the server; values as the server's API says them.

import type { Limits, RiderSettings } from "../messages";

export type Answer<T> = { ok: true; value: T } | { ok: false; status: number; text: string };

export interface Me {
  role: "driver" | "therapist";
  needs_token: boolean;
}

export interface StopNote {
  time: number;
  duration: number;
  code: string;
  text: string;
}

export interface RideRecord {
  id: string;
  began: string;
  seed: number;
  destination: string;
  outcome: "arrived" | "left" | "collision";
  time: number;
  length: number;
  modes: Record<string, number>;
  devices: Record<string, number>;
  wishes: number;
  limits: { time: number; limits: Limits }[];
  stops: StopNote[];
  rating: number | null;
  measures: Record<string, number>;
  trouble: string;
}

export interface Session {
  facts: { id: string; began: string; scene: string; robot: string; simulation: boolean };
  rides: RideRecord[];
}

export interface Entry {
  at: string;
  who: string;
  what: string;
  said: Record<string, unknown>;
}

const UNREACHABLE = "The chair’s server does not answer.";

/** Asks the server; what it refuses comes back in its own words, and nothing is thrown. */
export async function ask<T>(method: string, path: string, body?: unknown): Promise<Answer<T>> {
  try {
    const sent = body === undefined ? {} : json(body);
    const answer = await fetch(path, { method, credentials: "same-origin", ...sent });
    const said: unknown = await answer.json().catch(() => null);
    if (answer.ok) return { ok: true, value: said as T };
    return { ok: false, status: answer.status, text: sentence(textOf(said, answer.status)) };
  } catch {
    return { ok: false, status: 0, text: UNREACHABLE };
  }
}

export const api = {
  me: () => ask<Me>("GET", "/api/me"),
  signIn: (token: string) => ask<{ role: Me["role"] }>("POST", "/api/sign-in", { token }),
  signOut: () => ask<null>("POST", "/api/sign-out"),
  limits: (limits: Limits) => ask<Limits>("PUT", "/api/limits", limits),
  rider: (rider: RiderSettings) => ask<RiderSettings>("PUT", "/api/rider", rider),
  sessions: () => ask<Session[]>("GET", "/api/sessions"),
  deleteSessions: () => ask<{ deleted: number }>("DELETE", "/api/sessions"),
  audit: () => ask<Entry[]>("GET", "/api/audit"),
};

/** Where a session's export or a ride's map is. */
export function fileOf(id: string, ending: "html" | "csv" | "png"): string {
  return `/api/sessions/${encodeURIComponent(id)}.${ending}`;
}

/** The token of a link `#token=…`; the address forgets it, so that it stays in no history. */
export function tokenOfLink(window: Pick<Window, "location" | "history">): string | null {
  const { location, history } = window;
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (token === null) return null;
  history.replaceState(null, "", location.pathname + location.search);
  return token.slice(0, 200);
}

function json(body: unknown): RequestInit {
  return { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
}

function textOf(said: unknown, status: number): string {
  if (said !== null && typeof said === "object" && "text" in said && typeof said.text === "string") {
    return said.text;
  }
  return `the server refused this (${status})`;
}

/** The server's words begin small and end without a stop. */
function sentence(text: string): string {
  const end = /[.!?]$/.test(text) ? "" : ".";
  return text.charAt(0).toUpperCase() + text.slice(1) + end;
}
