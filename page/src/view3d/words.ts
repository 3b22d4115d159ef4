// The view in words, for whoever does not see it.

import { num, serverText, t } from "../i18n/text.svelte";
import { nearestEdge } from "../map/edges";
import type { Box } from "../map/view";
import type { ChairState, PersonInfo } from "../messages";

/** People and edges farther away are not told, m (assumed). */
const NEAR = 6;
const MOST_TOLD = 3;
const WALKS = 0.15;

type Told = Pick<ChairState, "pose" | "speed" | "turn_rate" | "goal" | "remaining" | "people" | "reason" | "arrived">;

/** Chair, trip and the nearest people, in sentences. */
export function inWords(state: Told | null, edges: readonly Box[] = []): string {
  if (!state) return t("view3d.notConnected");
  return [motion(state), trip(state), edge(state, edges), ...people(state)].filter(Boolean).join(" ");
}

function motion({ speed, turn_rate, reason }: Told): string {
  if (Math.abs(speed) < 0.05 && Math.abs(turn_rate) < 0.1) {
    return reason ? t("view3d.standsBecause", { reason: serverText(reason.text) }) : t("view3d.stands");
  }
  if (Math.abs(speed) < 0.05) return t(turn_rate > 0 ? "view3d.turnsLeft" : "view3d.turnsRight");
  return t(speed > 0 ? "view3d.forward" : "view3d.back", { speed: num(Math.abs(speed), 1) });
}

function trip({ goal, remaining, arrived }: Told): string {
  if (!goal) return "";
  const name = goal.name || t("view3d.point");
  if (arrived) return t("view3d.arrived", { name });
  return remaining === null ? t("view3d.goes", { name }) : t("view3d.remain", { metres: remaining, name });
}

function edge({ pose }: Told, edges: readonly Box[]): string {
  const at = nearestEdge(pose, edges, NEAR);
  if (!at) return "";
  const [dx, dy] = [at[0] - pose[0], at[1] - pose[1]];
  return t("view3d.edge", { far: num(Math.hypot(dx, dy), 1), direction: direction(Math.atan2(dy, dx) - pose[2]) });
}

function people({ people: all, pose }: Told): string[] {
  const near = all
    .map((person) => ({ person, far: Math.hypot(person.x - pose[0], person.y - pose[1]) }))
    .filter(({ far }) => far <= NEAR)
    .sort((a, b) => a.far - b.far);
  const count = near.length;
  if (count === 0) return [t("view3d.nobody", { near: NEAR })];
  const told = near.slice(0, MOST_TOLD).map(({ person, far }) => one(person, far, pose));
  return [t(count === 1 ? "view3d.person" : "view3d.people", { count, near: NEAR }), `${told.join("; ")}.`];
}

function one(person: PersonInfo, far: number, pose: ChairState["pose"]): string {
  const [dx, dy] = [person.x - pose[0], person.y - pose[1]];
  const walks = Math.hypot(person.vx, person.vy) >= WALKS;
  const nearer = -(dx * person.vx + dy * person.vy) / Math.max(far, 1e-6);
  const moves = nearer > 0.3 ? "comes" : nearer < -0.3 ? "leaves" : "crosses";
  const way = t(`view3d.${walks ? moves : "standing"}`);
  return t("view3d.one", { far: num(far, 1), direction: direction(Math.atan2(dy, dx) - pose[2]), way });
}

/** Direction of an angle from straight ahead, rad; positive is to the left (REP-103). */
export function direction(angle: number): string {
  const turned = Math.atan2(Math.sin(angle), Math.cos(angle));
  const left = turned > 0;
  const size = (Math.abs(turned) * 180) / Math.PI;
  if (size < 22.5) return t("view3d.ahead");
  if (size < 67.5) return t(left ? "view3d.aheadLeft" : "view3d.aheadRight");
  if (size < 112.5) return t(left ? "view3d.onLeft" : "view3d.onRight");
  return size < 157.5 ? t(left ? "view3d.behindLeft" : "view3d.behindRight") : t("view3d.straightBehind");
}
