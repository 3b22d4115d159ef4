// Requests of the therapist view to the server, with the types of its API.

import type { Limits, RiderSettings } from "../messages";
import { ask, type Role } from "../server";

export interface Me {
  role: Role;
  needs_token: boolean;
}

export interface RideStop {
  time: number;
  duration: number;
  code: string;
  text: string;
}

export interface RideSummary {
  id: string;
  started: string;
  seed: number;
  destination: string;
  outcome: "arrived" | "cancelled" | "collision" | "fell";
  duration: number;
  length: number;
  modes: Record<string, number>;
  devices: Record<string, number>;
  wishes: number;
  limits: { time: number; limits: Limits }[];
  stops: RideStop[];
  /** Smallest gap to a person, known before the measures are, m. */
  nearest?: number | null;
  rating: number | null;
  measures: Record<string, number>;
  error: string;
}

export interface SessionSummary {
  session: { id: string; started: string; scene: string; robot: string; simulation: boolean; rider: string };
  rides: RideSummary[];
}

/** What the chair has learned of its rider, and from how many rides. */
export interface RiderResponse {
  tight_speed: number;
  turn_share: number;
  steadiness: number;
  rides: Partial<Record<"tight_speed" | "turn_share" | "steadiness", number>>;
  since: string;
}

export interface AuditEntry {
  time: string;
  actor: string;
  event: string;
  details: Record<string, unknown>;
}

export const api = {
  me: () => ask<Me>("GET", "/api/me"),
  signOut: () => ask<null>("POST", "/api/sign-out"),
  limits: (limits: Limits) => ask<Limits>("PUT", "/api/limits", limits),
  allowEdges: () => ask<null>("POST", "/api/edges"),
  rider: (rider: RiderSettings) => ask<RiderSettings>("PUT", "/api/rider", rider),
  sessions: () => ask<SessionSummary[]>("GET", "/api/sessions"),
  deleteSessions: () => ask<{ deleted: number }>("DELETE", "/api/sessions"),
  learned: () => ask<RiderResponse>("GET", "/api/response"),
  forget: () => ask<RiderResponse>("DELETE", "/api/response"),
  audit: () => ask<AuditEntry[]>("GET", "/api/audit"),
};

/** Address of a session's export or a ride's map. */
export function fileOf(id: string, ending: "html" | "csv" | "png" | "timeline.json"): string {
  return `/api/sessions/${encodeURIComponent(id)}.${ending}`;
}
