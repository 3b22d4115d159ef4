// Latest messages of the chair, for the components that show them.

import { languageNow, t } from "./i18n/text.svelte";
import { boxesOf } from "./map/edges";
import type { Box } from "./map/view";
import { inLanguage } from "./places";
import type { Link, Status } from "./link";
import type {
  RideEnded,
  Limits,
  MapDifferences,
  Notice,
  RiderSettings,
  RouteUpdate,
  SceneInfo,
  ChairState,
  ToPage,
  TripPlans,
  Welcome,
} from "./messages";

/** Twenty states a second come; without one for this long something is wrong, ms. */
const STALE = 600;

/** So long the first heartbeat of a page that has taken control may be on its way, ms (assumed). */
const FIRST_BEAT = 1_000;
/** A later one that is late for less is not told of, ms (assumed): a jerk is not felt as a stop. */
const LATE_BEAT = 400;

const NO_ROUTE: RouteUpdate = {
  type: "route",
  version: 0,
  points: [],
  without_wishes: [],
  length: 0,
  extra_length: 0,
  wishes: [],
  error: "",
  cause: "first",
};

export class Chair {
  status = $state<Status>("connecting");
  /** This page's own name among the pages. */
  client = $state("");
  role = $state<Welcome["role"]>("driver");
  #scene = $state.raw<SceneInfo | null>(null);
  /** With the names of places in the page's language, where the map has them; the chair knows places by any name. */
  scene = $derived(this.#scene && { ...this.#scene, places: inLanguage(this.#scene.places, languageNow()) });
  limits = $state.raw<Limits | null>(null);
  rider = $state.raw<RiderSettings | null>(null);
  state = $state.raw<ChairState | null>(null);
  route = $state.raw<RouteUpdate>(NO_ROUTE);
  /** Where the building differs from the map; null: nothing is known. */
  differences = $state.raw<MapDifferences | null>(null);
  /** Floor behind edges that the chair has found, m. */
  edges = $state.raw<readonly Box[]>([]);
  /** The finished ride, until it is rated or the next one begins. */
  ended = $state.raw<RideEnded | null>(null);
  notice = $state.raw<Notice | null>(null);
  /** The newest routes to choose from, whoever asked for them on this page. */
  plans = $state.raw<TripPlans | null>(null);
  /** Where the finished ride led; a later destination takes its announcement away. */
  endedGoal = $state.raw<ChairState["goal"]>(null);
  /** Where the last ride arrived, until the chair has a destination or a ride again; null: it has not. */
  arrival = $state.raw<{ readonly ride: string; readonly name: string } | null>(null);
  #lastGoal: ChairState["goal"] = null;
  /** When this page took control, ms. */
  #took = -Infinity;
  /** Since when the chair misses this page's heartbeats, ms. */
  #missedSince = -Infinity;
  /** The link before that: a chair that waits for "Go on" still does. */
  #heldLink: ChairState["link"] = "ready";
  /** When the newest state came, by the page's own clock, ms. */
  came = 0;
  /** Connected, and yet no state comes. */
  stale = $state(false);
  /** True if this page drives. */
  driving = $derived(this.client !== "" && this.state?.driver === this.client);
  readonly goal = $derived(this.state?.goal ?? null);
  /**
   * The state that the page shows. The chair calls a connection lost until the first heartbeat of a
   * page that has taken control, and where one comes late on a busy computer; then nothing has been lost.
   */
  readonly displayedState = $derived.by(() => {
    const { state } = this;
    if (state?.link !== "no_heartbeat" || !this.driving) return state;
    const soon = this.came - this.#took < FIRST_BEAT || this.came - this.#missedSince < LATE_BEAT;
    return soon ? { ...state, link: this.#heldLink, reason: null } : state;
  });

  /** A place by the name that the page shows, whichever of its names is given. */
  placeName(name: string): string {
    const at = this.#scene?.places.findIndex((each) => each.name === name || Object.values(each.names ?? {}).includes(name)) ?? -1;
    return this.scene?.places[at]?.name ?? name;
  }

  /** The reason; on the driver's own screen, the one that lost the connection is this one. */
  #here({ driver, reason }: ChairState): ChairState["reason"] {
    const lost = driver === this.client && reason?.code === "connection_lost";
    return lost ? { ...reason, text: t("ready.lost") } : reason;
  }

  #translated<N extends { readonly name: string }>(named: N): N {
    return { ...named, name: this.placeName(named.name) };
  }

  follow(link: Link): void {
    link.watch((status) => {
      this.status = status;
      if (status !== "open") this.state = null;
    });
    link.listen((message) => this.heard(message));
  }

  /** Looks whether states still come. */
  look(now: number): void {
    this.stale = this.state !== null && now - this.came > STALE;
  }

  heard(message: ToPage): void {
    switch (message.type) {
      case "welcome":
        this.client = message.client;
        this.role = message.role;
        this.#scene = message.scene;
        this.limits = message.limits;
        this.rider = message.rider;
        this.differences = null;
        this.notice = null;
        this.edges = [];
        break;
      case "settings_changed":
        this.limits = message.limits;
        this.rider = message.rider;
        break;
      case "state": {
        this.came = performance.now();
        if (message.driver === this.client && this.state?.driver !== this.client) this.#took = this.came;
        if (message.link !== "no_heartbeat") this.#heldLink = message.link === "no_driver" ? "ready" : message.link;
        if (message.link === "no_heartbeat" && this.state?.link !== "no_heartbeat") this.#missedSince = this.came;
        this.state = {
          ...message,
          goal: message.goal && this.#translated(message.goal),
          offers: message.offers?.map((each) => this.#translated(each)),
          reason: message.reason && this.#here(message),
        };
        this.stale = false;
        if (this.ended && message.ride && message.ride !== this.ended.ride) this.ended = null;
        if (this.ended && message.goal && !samePlace(message.goal, this.endedGoal)) this.ended = null;
        if (this.arrival && (message.ride ? message.ride !== this.arrival.ride : departs(message, this.endedGoal))) {
          this.arrival = null;
        }
        if (message.goal) this.#lastGoal = message.goal;
        break;
      }
      case "route":
        this.route = message;
        break;
      case "map_differences":
        this.differences = message;
        break;
      case "edge_cells":
        if (this.#scene) this.edges = boxesOf(message.runs, this.#scene.floor);
        break;
      case "trip_plans":
        this.plans = message;
        break;
      case "notice":
        this.notice = message;
        break;
      case "ride_ended":
        this.ended = message;
        this.endedGoal = this.#lastGoal;
        this.arrival = message.outcome === "arrived" ? { ride: message.ride, name: this.#lastGoal?.name ?? "" } : null;
        break;
      default:
    }
  }
}

function departs({ goal }: ChairState, last: ChairState["goal"]): boolean {
  return goal !== null && !samePlace(goal, last);
}

function samePlace(goal: NonNullable<ChairState["goal"]>, other: ChairState["goal"]): boolean {
  return other !== null && goal.x === other.x && goal.y === other.y;
}

export const chair = new Chair();
