// News of a route that the chair changed on the way: said once, with its reason as far as it is known.

import { doorOn, type About } from "./around";
import { chair } from "./chair.svelte";
import { cues } from "./cues.svelte";
import { t, type Key } from "./i18n/text.svelte";
import { distanceToLine, farthestFrom, lastOf } from "./map/strokes";
import type { ChairState, RouteUpdate, SceneInfo } from "./messages";
import { causeWords, detour, throughName } from "./words";

/** A new route that is nowhere farther from the old one is the same way, m (assumed): a corridor's width. */
const SAME_WAY = 2.5;
/** It stays to be read so long, ms (assumed). */
const SHOWN = 10_000;

type Goal = ChairState["goal"];

export interface Change {
  readonly before: Pick<RouteUpdate, "points">;
  readonly now: Pick<RouteUpdate, "points" | "length" | "cause">;
  /** What was left of the old route, m. */
  readonly left: number;
}

/** The news of a change in words; empty: it is none, or the rider's own doing. */
export function newsOf(
  { before, now, left }: Change,
  state: About,
  scene: Pick<SceneInfo, "doors" | "places">,
): string {
  const key = `newRoute.${now.cause}` as Key;
  if (!OWN.has(now.cause) || before.points.length < 2) return "";
  const old = lastOf(before.points, left);
  const at = farthestFrom(now.points, old);
  if (!at || distanceToLine(at, old) < SAME_WAY) return "";
  const door = doorOn(state, scene, old);
  const why = door ? t("newRoute.door", { why: causeWords(door) }) : t(key);
  const more = now.length - left;
  const extra = Math.abs(more) < 1 ? t("newRoute.asLong") : detour(more);
  const name = throughName(now.points, old, scene.places);
  return `${why} ${name ? t("newRoute.through", { name, detour: extra }) : t("newRoute.only", { detour: extra })}`;
}

/** Causes that are the chair's own; a destination or a wish is the rider's. */
const OWN = new Set(["blocked", "stalled", "backed_up", "turn", "steering", "off_path"]);

class RouteNews {
  words = $state("");
  #route: RouteUpdate | null = null;
  #goal: Goal = null;
  #left = 0;
  #until = -Infinity;

  /** Called ten times a second. */
  look(now: number): void {
    const { state, route, scene, goal } = chair;
    if (!state || !scene) return;
    const before = this.#route;
    const same = before !== null && goal !== null && this.#goal !== null && goal.x === this.#goal.x && goal.y === this.#goal.y;
    if (before && same && route.version !== before.version) {
      const words = newsOf({ before, now: route, left: this.#left }, state, scene);
      if (words) {
        this.words = words;
        this.#until = now + SHOWN;
        cues.say(words);
      }
    }
    if (!goal || now > this.#until) this.words = "";
    this.#goal = goal;
    if (route.points.length > 0 || !goal) this.#route = route;
    if (state.remaining !== null && state.route_version === this.#route?.version) this.#left = state.remaining;
  }
}

export const routeNews = new RouteNews();
