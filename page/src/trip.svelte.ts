// A trip before it begins: destination, wishes on the way, and the routes to choose from.

import { chair } from "./chair.svelte";
import { t } from "./i18n/text.svelte";
import { inputs } from "./input/live";
import { link, PRICE_WITHIN } from "./link";
import { selection } from "./mapSelection.svelte";
import type { Notice, RouteUpdate, RouteWish, SetGoal, TripPlans, TripRoute } from "./messages";
import { mapView } from "./map/mapView.svelte";
import { distance, drawn, zoneOf } from "./map/strokes";
import type { Point } from "./map/view";
import { passed } from "./passed.svelte";
import { remember } from "./places";
import { avoidWish, named, notAvoided, viaWish, type Where, type Wished } from "./wishes";
import { metres } from "./words";

export type To = { readonly place: string } | { readonly point: Point };

/** A trip that is looked at before it begins. */
export interface Draft {
  readonly to: To;
  readonly name: string;
  readonly wishes: readonly Wished[];
  readonly plans: TripPlans | null;
  readonly chosen: number;
  readonly trouble: string;
  /** No answer came, so that another attempt may succeed. */
  readonly unanswered: boolean;
  /** Where the chair was when the routes were planned. */
  readonly from: Point | null;
  /** The routes are being planned. */
  readonly busy: boolean;
  /** The routes on display are those of other wishes. */
  readonly outdated: boolean;
}

/** After this way the routes are planned anew: lengths and prices are told from where the chair is, m. */
const STALE = 3;
/** Waiting times before the attempts that follow an unanswered one, ms (assumed); after the last it is the rider's turn. */
const AGAIN = [2_000, 6_000, 15_000] as const;
/** Refusals that say nothing about the trip itself. */
const UNANSWERED = new Set(["no_answer", "link_lost", "preview_failed", "too_many_requests"]);
/** A place counts as visited within this, m (assumed): a chair's length. */
const VISITED = 1;
/** Points nearer than this are the same, m. */
const SAME = 0.05;
/** What begins anew, for another person: nothing of before is of their trip. */
const ANEW = new Set(["rider_chosen", "simulation_restarted", "storey_changes"]);

export class Trip {
  draft = $state.raw<Draft | null>(null);
  /** True if the overview of the draft is shown; a draft is kept until it begins or is cancelled. */
  open = $state(false);
  #asked = 0;
  /** No routes can be planned now: they are as soon as they can. */
  #waits = false;
  /** Attempts in a row without an answer, and when the next one is due, ms. */
  #failed = 0;
  #again = Infinity;
  #notice: Notice | null = null;
  /** The point by which the chosen alternative leads: it is no wish of the rider. */
  #via: Point | null = null;

  constructor() {
    selection.drawing = (line, avoided) => void this.stroke(line, avoided);
  }

  readonly routes = $derived<readonly TripRoute[]>(this.draft?.plans?.routes ?? []);
  readonly route = $derived<TripRoute | null>(this.routes[this.draft?.chosen ?? 0] ?? null);

  /** True if the overview is open, and its route is of the wishes on display. */
  get startable(): boolean {
    return this.open && this.route !== null && !this.draft?.outdated;
  }

  /** True while the chair is on a trip, which another one would replace. */
  get under(): boolean {
    return chair.goal !== null && !chair.state?.arrived;
  }

  /** What the map shows of the chair's way: before a change holds, its wishes and none that it removes. */
  readonly shown = $derived.by((): RouteUpdate => {
    return this.draft ? { ...chair.route, wishes: numbered(this.draft.wishes.map(({ wish }) => wish)) } : chair.route;
  });

  /** That the best route does not keep the k-th wish, and what it does instead; empty: it keeps it, or nobody knows. */
  unkept(k: number): string {
    const { wishes = [], plans, outdated } = this.draft ?? {};
    const wish = wishes[k]?.wish;
    if (!wish || !plans || outdated) return "";
    const before = wishes.slice(0, k).filter((each) => each.wish.kind === wish.kind);
    if (wish.kind === "avoid") return notAvoided(plans.through[before.length] ?? 0);
    if (wish.kind !== "attract") return "";
    const first = before.reduce((sum, each) => sum + each.wish.points.length, 0);
    const most = Math.max(0, ...plans.closest.slice(first, first + wish.points.length));
    return most > VISITED ? t("trip.missed", { metres: metres(most) }) : "";
  }

  /**
   * Opens the overview; where the therapist allows it, the chair sets off at once.
   *
   * Another destination keeps the wishes of a trip that has not begun; those of one under way end with
   * it.
   */
  choose(to: To, name: string, wishes: readonly Wished[] = this.draft?.wishes ?? []): Promise<void> {
    selection.cancel();
    if (chair.rider?.start_at_once && !chair.state?.preparing) return this.#go(to, name, wishes.map(({ wish }) => wish));
    return this.#look(to, name, wishes);
  }

  #look(to: To, name: string, wishes: readonly Wished[]): Promise<void> {
    this.draft = {
      to, name, wishes, plans: null, chosen: 0, trouble: "", unanswered: false, from: null, busy: true, outdated: false,
    };
    this.show();
    return this.again();
  }

  /** The overview of the trip that is under way, with one more wish or none. */
  change(...more: readonly Wished[]): Promise<void> {
    const { goal } = chair;
    if (this.draft || !goal) return Promise.resolve(this.show());
    selection.cancel();
    return this.#look(goal.name ? { place: goal.name } : { point: [goal.x, goal.y] }, goal.name, [...activeWishes(this.#via), ...more]);
  }

  /** True if the unanswered question is asked again without the rider. */
  get retries(): boolean {
    return this.draft?.unanswered === true && this.#failed <= AGAIN.length;
  }

  pick(chosen: number): void {
    if (this.draft) this.draft = { ...this.draft, chosen };
  }

  via(place: Where): Promise<void> {
    return this.add(viaWish(place));
  }

  avoid(place: Where): Promise<void> {
    return this.add(avoidWish(place));
  }

  /** A line was drawn. */
  stroke(line: readonly Point[], avoided: boolean): Promise<void> {
    return avoided
      ? this.add({ wish: { kind: "avoid", ...zoneOf(line), visit: false }, words: t("trip.avoidArea") })
      : this.add({ wish: { kind: "stroke", points: drawn(line), radius: 0, visit: false }, words: t("trip.followLine") });
  }

  add(wished: Wished): Promise<void> {
    return this.draft ? this.#wish((wishes) => [...wishes, wished]) : this.change(wished);
  }

  remove(k: number): Promise<void> {
    return this.#wish((wishes) => wishes.filter((_, n) => n !== k));
  }

  show(): void {
    if (!this.draft) return;
    this.open = true;
    mapView.follow = "route";
  }

  /** Away with the overview; the trip is kept. */
  hide(): void {
    if (!this.open) return;
    this.open = false;
    if (mapView.follow === "route") mapView.back();
    selection.cancel();
  }

  /** Cancels a trip that has not begun, or the change of one that has. */
  close(): void {
    this.hide();
    this.draft = null;
  }

  /** The rider wants the routes now. */
  again(): Promise<void> {
    this.#failed = 0;
    return this.#plan();
  }

  async start(): Promise<void> {
    const { draft, route } = this;
    if (!draft || draft.outdated) return;
    const wishes = draft.wishes.map((each) => each.wish);
    if (route?.via) wishes.push({ kind: "attract", points: [route.via], radius: 0, visit: false });
    this.#via = route?.via ?? null;
    await this.#go(draft.to, draft.name, wishes, this.#choice(draft));
  }

  /** Looks, from time to time, whether what is shown is old. */
  look(): void {
    if (chair.notice !== this.#notice) {
      this.#notice = chair.notice;
      if (ANEW.has(chair.notice?.code ?? "")) this.close();
    }
    const { draft } = this;
    const { state, plans } = chair;
    if (!draft || !state) return;
    // The alternatives, to the first route that has come before them.
    if (plans && plans.id === draft.plans?.id && !draft.plans.complete && plans.complete) {
      const { length } = this.route ?? {};
      this.draft = { ...draft, plans, chosen: Math.max(0, plans.routes?.findIndex((each) => each.length === length) ?? 0) };
    }
    if (!plannable()) {
      // The routes that were not planned for lack of a planner are, once there is one.
      this.#waits ||= draft.unanswered && this.#failed <= AGAIN.length;
      return;
    }
    if (this.#waits || (draft.unanswered && !draft.busy && performance.now() >= this.#again)) {
      void this.#plan();
      return;
    }
    if (!draft.from || draft.busy) return;
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
    // The press is the confirmation that the chair waits for now. Before the destination, and never
    // later: a STOP that comes after it must hold.
    // Who takes over a trip under way confirms apart: if this one were refused, that one would go on.
    if (!chair.state?.driver) link.send({ type: "take_control", confirm: !chair.state?.not_ready && !this.under });
    else if (chair.driving && chair.state.link === "confirm") inputs.resume();
    const answer = await link.ask({ type: "set_goal", ...to, ...(wishes ? { wishes: [...wishes], choice } : {}) });
    selection.heed(answer);
    if (answer.type === "rejected") return;
    this.close();
    mapView.back();
    if (name) remember(name);
  }

  #wish(how: (wishes: readonly Wished[]) => readonly Wished[]): Promise<void> {
    if (!this.draft) return Promise.resolve();
    this.draft = { ...this.draft, wishes: how(this.draft.wishes), outdated: true };
    this.show();
    return this.again();
  }

  async #plan(): Promise<void> {
    const { draft } = this;
    if (!draft) return;
    this.#waits = chair.state !== null && !plannable();
    this.draft = { ...draft, busy: true };
    if (this.#waits) return;
    const number = ++this.#asked;
    const pose = chair.state?.pose;
    const wishes = draft.wishes.map((each) => each.wish);
    const answer = await link.ask({ type: "plan_trip", ...draft.to, wishes }, PRICE_WITHIN);
    if (number !== this.#asked || !this.draft) return;
    const from = pose ? ([pose[0], pose[1]] as const) : null;
    const now = { ...this.draft, busy: false, outdated: false, unanswered: false, from };
    const unanswered = answer.type === "rejected" && UNANSWERED.has(answer.code);
    this.#failed = unanswered ? this.#failed + 1 : 0;
    this.#again = performance.now() + (AGAIN[this.#failed - 1] ?? Infinity);
    if (answer.type === "trip_plans") {
      const chosen = Math.min(now.chosen, Math.max(0, (answer.routes?.length ?? 0) - 1));
      this.draft = { ...now, plans: answer, chosen, trouble: answer.error ?? "" };
    } else if (answer.type === "rejected") {
      this.draft = { ...now, plans: null, trouble: answer.text, unanswered };
    }
  }
}

/** True if the chair would answer with routes. */
function plannable(): boolean {
  const { state } = chair;
  return state !== null && state.reason?.code !== "starting" && state.can_plan !== false;
}

/** Wishes that hold already: a changed trip keeps them until they are removed, or are behind the chair.
 * via: of the alternative under way, which is one of the routes to choose from. */
function activeWishes(via: Point | null): readonly Wished[] {
  const ofAlternative = ({ kind, points: [at] }: RouteWish): boolean =>
    kind === "attract" && via !== null && at !== undefined && distance(at, via) < SAME;
  const holding = chair.route.wishes.filter((wish) => !passed.has(wish) && !ofAlternative(wish));
  return holding.map(({ kind, points, radius, visit }) => named({ kind, points, radius, visit }, chair.scene?.places ?? []));
}

function numbered(wishes: readonly RouteWish[]): RouteUpdate["wishes"] {
  return wishes.map(({ kind, points, radius = 0, visit = false }, id) => ({ id, kind, points, radius, visit }));
}

export const trip = new Trip();
