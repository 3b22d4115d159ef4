// Wishes about a route in words, and the area that one to avoid a place covers.

import { nameBy } from "./around";
import { t } from "./i18n/text.svelte";
import { distance, drawn } from "./map/strokes";
import type { Point } from "./map/view";
import type { PlaceInfo, RouteWish } from "./messages";
import { metres } from "./words";

/** What is to be avoided about a point, or about a place that the map has no outline of, m (assumed). */
const AVOIDED = 1.5;
/** A point so near to a place's own is the place, m. */
const SAME_PLACE = 0.05;
/** Less of a route within an area to avoid is not told, m (assumed): it grazes a corner. */
const GRAZED = 0.5;

export interface Wished {
  readonly wish: Required<RouteWish>;
  readonly words: string;
  /** Name of the place to go via, if it is one. */
  readonly by?: string;
}

/** A place as far as a wish needs it: its outline, where the map has one. */
export type Where = Pick<PlaceInfo, "name" | "x" | "y"> & { readonly area?: PlaceInfo["area"] };

export function viaWish({ name, x, y }: Where): Wished {
  return { wish: { kind: "attract", points: [[x, y]], radius: 0, visit: true }, words: t("trip.via", { name }), by: name };
}

/** The whole place, by its outline; where the map has none, what lies about its point. */
export function avoidWish({ name, x, y, area = [] }: Where): Wished {
  const about = area.length < 3;
  const points: Point[] = about ? [[x, y]] : drawn(area);
  const radius = about ? AVOIDED : 0;
  const words = about ? t("trip.avoidAbout", { name, metres: metres(AVOIDED) }) : t("trip.avoid", { name });
  return { wish: { kind: "avoid", points, radius, visit: false }, words };
}

/** A wish that holds, with the words in which it was made. */
export function named(wish: Required<RouteWish>, places: PlaceInfo[]): Wished {
  const { kind, points } = wish;
  const [at] = points;
  if (kind === "stroke" || !at) return { wish, words: near(t("trip.followLine"), points, places) };
  const made = kind === "attract" ? viaWish : avoidWish;
  const place = places.find((each) => {
    const { wish: like } = made(each);
    return like.points.length === points.length && distance(like.points[0]!, at) < SAME_PLACE;
  });
  if (place) return { ...made(place), wish };
  return { wish, words: near(t(kind === "attract" ? "trip.viaPoint" : "trip.avoidArea"), points, places) };
}

function near(words: string, points: readonly Point[], places: PlaceInfo[]): string {
  const name = nameBy(places, points[Math.floor(points.length / 2)] ?? [0, 0]);
  return name ? `${words}, ${t("route.near", { name })}` : words;
}

/** That an area is not avoided, and how much of the best route leads through it; empty: it is avoided. */
export function notAvoided(through: number): string {
  return through < GRAZED ? "" : t("trip.notAvoided", { metres: metres(through) });
}
