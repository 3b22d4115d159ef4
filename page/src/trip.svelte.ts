// A trip before it begins: destination, wishes on the way, and the routes to choose from.

import { chair } from "./chair.svelte";
import { t } from "./i18n/text.svelte";
import { link, PRICE_WITHIN } from "./link";
import { selection } from "./mapSelection.svelte";
import type { RouteWish, SetGoal, TripPlans, TripRoute } from "./messages";
import { mapView } from "./map/mapView.svelte";
import { drawn, zoneOf } from "./map/strokes";
import type { Point } from "./map/view";
import { remember } from "./places";

export type To = { readonly place: string } | { readonly point: Point };

export interface Wished {
  readonly wish: Required<RouteWish>;
  readonly words: string;
}

/** A trip that is looked at before it begins. */
export interface Draft {
  readonly to: To;
  readonly name: string;
  readonly wishes: readonly Wished[];
  readonly plans: TripPlans | null;
  readonly chosen: number;
  readonly trouble: string;
  /** Where the chair was when the routes were planned. */
  readonly from: Point | null;
  /** The routes are being planned. */
  readonly busy: boolean;
  /** The routes on display are those of other wishes. */
  readonly outdated: boolean;
}

/** After this way the routes are planned anew: lengths and prices are told from where the chair is, m. */
const STALE = 3;
/** Radius of the area to avoid about a place, m. */
const AVOIDED = 1.5;
/** A point so near to a place's own is the place, m. */
const SAME_PLACE = 0.05;
/** A place counts as visited within this, m (assumed): a chair's length. */
const VISITED = 1;

export class Trip {
  draft = $state.raw<Draft | null>(null);
  #asked = 0;
  /** The chair starts up: it plans as soon as it can. */
  #waits = false;

  constructor() {
    selection.drawing = (line, avoided) => {
      if (this.draft) void this.stroke(line, avoided);
      return this.draft !== null;
    };
  }

  readonly routes = $derived<readonly TripRoute[]>(this.draft?.plans?.routes ?? []);
  readonly route = $derived<TripRoute | null>(this.routes[this.draft?.chosen ?? 0] ?? null);

  /** How far from the k-th wish the first route stays, m; null: it is no point to go via, or unknown. */
  missed(k: number): number | null {
    const { draft } = this;
    if (!draft?.plans || draft.wishes[k]?.wish.kind !== "attract") return null;
    const before = draft.wishes.slice(0, k).filter(({ wish }) => wish.kind === "attract");
    const first = before.reduce((sum, { wish }) => sum + wish.points.length, 0);
    const all = draft.plans.closest.slice(first, first + draft.wishes[k].wish.points.length);
    const most = Math.max(0, ...all);
    return most > VISITED ? most : null;
  }

  /**
   * Opens the overview; where the therapist allows it, the chair sets off at once.
   *
   * A new destination keeps what is to be avoided; a place on the way was one of the former trip.
   */
  choose(to: To, name: string, wishes: readonly Wished[] = activeWishes().filter(({ wish }) => wish.kind === "avoid")): Promise<void> {
    selection.cancel();
    if (chair.rider?.start_at_once) return this.#go(to, name, null);
    this.draft = {
      to, name, wishes, plans: null, chosen: 0, trouble: "", from: null, busy: true, outdated: false,
    };
    mapView.follow = "route";
    return this.#plan();
  }

  /** The overview of the trip that is under way. */
  change(): Promise<void> {
    const { goal } = chair;
    if (!goal) return Promise.resolve();
    return this.choose(goal.name ? { place: goal.name } : { point: [goal.x, goal.y] }, goal.name, activeWishes());
  }

  pick(chosen: number): void {
    if (this.draft) this.draft = { ...this.draft, chosen };
  }

  via(point: Point, name: string): Promise<void> {
    return this.add({ kind: "attract", points: [point], radius: 0, visit: true }, t("trip.via", { name }));
  }

  avoid(point: Point, name: string): Promise<void> {
    return this.add({ kind: "avoid", points: [point], radius: AVOIDED, visit: false }, t("trip.avoid", { name }));
  }

  /** A line was drawn while the overview is open. */
  stroke(line: readonly Point[], avoided: boolean): Promise<void> {
    return avoided
      ? this.add({ kind: "avoid", ...zoneOf(line), visit: false }, t("trip.avoidArea"))
      : this.add({ kind: "stroke", points: drawn(line), radius: 0, visit: false }, t("trip.followLine"));
  }

  add(wish: Required<RouteWish>, words: string): Promise<void> {
    return this.#wish((wishes) => [...wishes, { wish, words }]);
  }

  remove(k: number): Promise<void> {
    return this.#wish((wishes) => wishes.filter((_, n) => n !== k));
  }

  close(): void {
    this.draft = null;
    mapView.back();
    selection.cancel();
  }

  async start(): Promise<void> {
    const { draft, route } = this;
    if (!draft || draft.outdated) return;
    const wishes = draft.wishes.map((each) => each.wish);
    if (route?.via) wishes.push({ kind: "attract", points: [route.via], radius: 0, visit: false });
    await this.#go(draft.to, draft.name, wishes, this.#choice(draft));
  }

  /** Looks, from time to time, whether what is shown is old. */
  look(): void {
    const { draft } = this;
    const { state } = chair;
    if (!state) return;
    if (draft && this.#waits && state.reason?.code !== "starting") {
      void this.#plan();
      return;
    }
    if (!draft?.from || draft.busy) return;
    if (Math.hypot(state.pose[0] - draft.from[0], state.pose[1] - draft.from[1]) > STALE) void this.#plan();
  }

  /** The order of the routes is learned from what was chosen among several. */
  #choice(draft: Draft): SetGoal["choice"] {
    const figures = this.routes.map((each) => each.figures);
    return figures.length > 1 ? { figures, taken: draft.chosen } : null;
  }

  async #go(
    to: To,
    name: string,
    wishes: readonly Required<RouteWish>[] | null,
    choice: SetGoal["choice"] = null,
  ): Promise<void> {
    if (!chair.state?.driver) link.send({ type: "take_control" });
    // The press is the confirmation that the chair waits for now. Before the destination, and never
    // later: a STOP that comes after it must hold.
    else if (chair.driving && chair.state.link === "confirm" && !chair.state.not_ready) link.send({ type: "resume" });
    const answer = await link.ask({ type: "set_goal", ...to, ...(wishes ? { wishes: [...wishes], choice } : {}) });
    selection.heed(answer);
    if (answer.type === "rejected") return;
    this.draft = null;
    mapView.back();
    if (name) remember(name);
  }

  #wish(how: (wishes: readonly Wished[]) => readonly Wished[]): Promise<void> {
    if (!this.draft) return Promise.resolve();
    this.draft = { ...this.draft, wishes: how(this.draft.wishes), outdated: true };
    return this.#plan();
  }

  async #plan(): Promise<void> {
    const { draft } = this;
    if (!draft) return;
    this.draft = { ...draft, busy: true };
    this.#waits = chair.state?.reason?.code === "starting";
    if (this.#waits) return;
    const number = ++this.#asked;
    const pose = chair.state?.pose;
    const wishes = draft.wishes.map((each) => each.wish);
    const answer = await link.ask({ type: "plan_trip", ...draft.to, wishes }, PRICE_WITHIN);
    if (number !== this.#asked || !this.draft) return;
    const now = { ...this.draft, busy: false, outdated: false, from: pose ? ([pose[0], pose[1]] as const) : null };
    if (answer.type === "trip_plans") {
      const chosen = Math.min(now.chosen, Math.max(0, (answer.routes?.length ?? 0) - 1));
      this.draft = { ...now, plans: answer, chosen, trouble: answer.error ?? "" };
    } else if (answer.type === "rejected") {
      this.draft = { ...now, plans: null, trouble: answer.text };
    }
  }
}

/** Wishes that hold already: a changed trip keeps them until they are removed. */
function activeWishes(): readonly Wished[] {
  const words = { attract: "trip.viaPoint", avoid: "trip.avoidArea", stroke: "trip.followLine" } as const;
  return chair.route.wishes.map(({ kind, points, radius, visit }) => ({
    wish: { kind, points: points.map(([x, y]) => [x, y] as const), radius, visit },
    words: viaWords(kind, points) || t(words[kind]),
  }));
}

/** The name of a place to go via is kept while the trip is under way. */
function viaWords(kind: RouteWish["kind"], points: readonly Point[]): string {
  const [x, y] = points[0] ?? [NaN, NaN];
  const place = chair.scene?.places.find((each) => Math.hypot(each.x - x, each.y - y) < SAME_PLACE);
  return place && kind === "attract" ? t("trip.via", { name: place.name }) : "";
}

export const trip = new Trip();
