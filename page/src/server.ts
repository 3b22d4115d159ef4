// Asking the chair's server; what both views need of it.

import { sentence, serverText, t } from "./i18n/text.svelte";

export type Answer<T> = { ok: true; value: T } | { ok: false; status: number; text: string };
export type Role = "driver" | "therapist";


/** Asks the server; what it refuses comes back in its own words, and nothing is thrown. */
export async function ask<T>(method: string, path: string, body?: unknown): Promise<Answer<T>> {
  try {
    const sent = body === undefined ? {} : json(body);
    const answer = await fetch(path, { method, credentials: "same-origin", ...sent });
    const said: unknown = await answer.json().catch(() => null);
    if (answer.ok) return { ok: true, value: said as T };
    return { ok: false, status: answer.status, text: sentence(serverText(textOf(said, answer.status))) };
  } catch {
    return { ok: false, status: 0, text: t("server.unreachable") };
  }
}

export function signIn(token: string): Promise<Answer<{ role: Role }>> {
  return ask("POST", "/api/sign-in", { token });
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
  return t("server.refused", { status: String(status) });
}

const RELOADED = "cohelm.reloaded";

/** A page that a browser kept from before the chair's program changed is loaded anew: once by
 * itself, as that need not help. Returns whether it is. */
export function reloadOnce(window: Pick<Window, "location" | "sessionStorage">): boolean {
  try {
    if (window.sessionStorage.getItem(RELOADED)) return false;
    window.sessionStorage.setItem(RELOADED, "1");
  } catch {
    return false; // what cannot be remembered could go on for ever
  }
  window.location.reload();
  return true;
}

/** The page is the chair's own again. */
export function reloaded(window: Pick<Window, "sessionStorage">): void {
  try {
    window.sessionStorage.removeItem(RELOADED);
  } catch {
    // nothing was kept
  }
}

/** A link opened where the page is open already changes only what is behind the #. */
export function heedLinks(window: Window): void {
  window.addEventListener("hashchange", () => {
    if (window.location.hash.startsWith("#token=")) window.location.reload();
  });
}
