// The view in words, for whoever does not see it.

import type { ChairState, PersonInfo } from "../messages";

/** People farther away are not told, m (assumed). */
const NEAR = 6;
const MOST_TOLD = 3;
const WALKS = 0.15;

type Told = Pick<ChairState, "pose" | "speed" | "turn_rate" | "goal" | "remaining" | "people" | "reason" | "arrived">;

/** Chair, trip and the nearest people, in sentences. */
export function inWords(state: Told | null): string {
  if (!state) return "Not connected to the chair.";
  return [motion(state), trip(state), ...people(state)].filter(Boolean).join(" ");
}

function motion({ speed, turn_rate, reason }: Told): string {
  if (Math.abs(speed) < 0.05 && Math.abs(turn_rate) < 0.1) {
    return reason ? `The chair stands: ${reason.text}` : "The chair stands.";
  }
  if (Math.abs(speed) < 0.05) return `The chair turns ${turn_rate > 0 ? "left" : "right"}.`;
  const way = speed > 0 ? "forward" : "back";
  return `The chair drives ${way} at ${Math.abs(speed).toFixed(1)} m/s.`;
}

function trip({ goal, remaining, arrived }: Told): string {
  if (!goal) return "";
  const name = goal.name || "the selected point";
  if (arrived) return `It has arrived at ${name}.`;
  return remaining === null ? `It goes to ${name}.` : `${Math.round(remaining)} m remain to ${name}.`;
}

function people({ people: all, pose }: Told): string[] {
  const near = all
    .map((person) => ({ person, far: Math.hypot(person.x - pose[0], person.y - pose[1]) }))
    .filter(({ far }) => far <= NEAR)
    .sort((a, b) => a.far - b.far);
  if (near.length === 0) return [`Nobody within ${NEAR} m.`];
  const count = near.length === 1 ? "1 person" : `${near.length} people`;
  const told = near.slice(0, MOST_TOLD).map(({ person, far }) => one(person, far, pose));
  return [`${count} within ${NEAR} m:`, `${told.join("; ")}.`];
}

function one(person: PersonInfo, far: number, pose: ChairState["pose"]): string {
  const [dx, dy] = [person.x - pose[0], person.y - pose[1]];
  const walks = Math.hypot(person.vx, person.vy) >= WALKS;
  const nearer = -(dx * person.vx + dy * person.vy) / Math.max(far, 1e-6);
  const way = !walks ? "standing" : nearer > 0.3 ? "coming nearer" : nearer < -0.3 ? "going away" : "crossing";
  return `${far.toFixed(1)} m ${direction(Math.atan2(dy, dx) - pose[2])}, ${way}`;
}

/** Direction of an angle from straight ahead, rad; positive is to the left (REP-103). */
export function direction(angle: number): string {
  const turned = Math.atan2(Math.sin(angle), Math.cos(angle));
  const side = turned > 0 ? "left" : "right";
  const size = (Math.abs(turned) * 180) / Math.PI;
  if (size < 22.5) return "ahead";
  if (size < 67.5) return `ahead on the ${side}`;
  if (size < 112.5) return `on the ${side}`;
  return size < 157.5 ? `behind on the ${side}` : "behind";
}
