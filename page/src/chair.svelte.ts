// The newest of everything that the chair told, for whoever shows it.

import type { Link, Status } from "./link";
import type {
  Ended,
  Limits,
  Notice,
  RiderSettings,
  Route,
  Scene,
  State,
  ToPage,
  Welcome,
} from "./messages";

/** Twenty states a second come; without one for this long something is wrong, ms. */
const STALE = 600;

const NO_ROUTE: Route = {
  type: "route",
  version: 0,
  points: [],
  without: [],
  length: 0,
  extra: 0,
  wishes: [],
  trouble: "",
};

export class Chair {
  status = $state<Status>("connecting");
  /** This page's own name among the pages. */
  client = $state("");
  role = $state<Welcome["role"]>("driver");
  scene = $state.raw<Scene | null>(null);
  limits = $state.raw<Limits | null>(null);
  rider = $state.raw<RiderSettings | null>(null);
  state = $state.raw<State | null>(null);
  route = $state.raw<Route>(NO_ROUTE);
  /** The ride that is over, until it was rated or the next one begins. */
  ended = $state.raw<Ended | null>(null);
  notice = $state.raw<Notice | null>(null);
  /** When the newest state came, by the page's own clock, ms. */
  came = 0;
  /** Connected, and yet no state comes. */
  stale = $state(false);
  /** Whether this page is the one that drives. */
  driving = $derived(this.client !== "" && this.state?.driver === this.client);
  readonly goal = $derived(this.state?.goal ?? null);

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
        this.scene = message.scene;
        this.limits = message.limits;
        this.rider = message.rider;
        break;
      case "configured":
        this.limits = message.limits;
        this.rider = message.rider;
        break;
      case "state":
        this.state = message;
        this.came = performance.now();
        this.stale = false;
        if (this.ended && message.ride && message.ride !== this.ended.ride) this.ended = null;
        break;
      case "route":
        this.route = message;
        break;
      case "notice":
        this.notice = message;
        break;
      case "ended":
        this.ended = message;
        break;
      default:
    }
  }
}

export const chair = new Chair();
