// What the therapist's view asks of the server; values as the server's API says them.

import type { Limits, RiderSettings } from "../messages";
import { ask, type Role } from "../server";

export interface Me {
  role: Role;
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

export const api = {
  me: () => ask<Me>("GET", "/api/me"),
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
