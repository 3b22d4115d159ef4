// Everything that is drawn, in the map's frame (REP-103: x forward, y left, z up).

import { Color, Group, Scene, type PerspectiveCamera } from "three";
import type { Shown } from "../map/motion";
import type { Colours } from "../map/palette";
import type { Box } from "../map/view";
import type { ChairState, SceneInfo } from "../messages";
import { building, type Building } from "./building";
import type { Sight } from "./cameras";
import type { FloorSolids } from "./floorSolids";
import { ground, pixelsOf, type TextureLimits } from "./ground";
import { lights } from "./light";
import { Markings, type Ways } from "./markings";
import { release } from "./parts";
import { People } from "./people";
import { Signs } from "./signs";
import { chairModel, type ChairModel } from "./wheelchair";

export interface Floor {
  readonly scene: Pick<SceneInfo, "floor" | "places" | "doors"> & { readonly chair: Pick<SceneInfo["chair"], "outline"> };
  readonly solids: FloorSolids;
  readonly image: HTMLImageElement;
}

/** What is drawn of a chair's state. */
export type Drawn = Pick<
  ChairState,
  "pose" | "speed" | "turn_rate" | "reason" | "people" | "true_people" | "closed_doors" | "plan" | "groups" | "goal"
>;

/** What moves, and how fast the chair does. */
export interface Moment {
  readonly shown: Shown;
  readonly twist: readonly [number, number];
  /** Since the last frame, s. */
  readonly seconds: number;
  /** False: nobody swings their legs and no wheel turns. */
  readonly moves: boolean;
}

export class World {
  readonly scene = new Scene();
  readonly #content = new Group();
  #building!: Building;
  #people!: People;
  #markings!: Markings;
  #signs!: Signs;
  #chair!: ChairModel;
  #state: Drawn | null = null;
  #ways: Ways | null = null;
  #edges: readonly Box[] = [];

  constructor(
    readonly floor: Floor,
    colours: Colours,
    readonly texture: TextureLimits,
  ) {
    this.scene.add(this.#content);
    this.recolour(colours);
  }

  /** Builds everything anew in other colours. */
  recolour(colours: Colours): void {
    const { scene, solids, image } = this.floor;
    release(this.#content);
    const pixels = pixelsOf(image);
    this.#building = building({ scene, solids, pixels, colours });
    this.#people = new People(colours);
    this.#markings = new Markings(colours, solids.wet);
    this.#signs = new Signs(scene.places, colours);
    this.#chair = chairModel(scene.chair, colours);
    this.scene.background = new Color(colours.unknown);
    this.#content.add(
      ...lights(colours),
      ground({ ...this.floor, pixels, colours }, this.texture),
      this.#building.group,
      this.#markings.group,
      this.#people.group,
      this.#chair.group,
      this.#signs.group,
    );
    this.#markings.edges(this.#edges);
    if (this.#ways) this.#markings.ways(this.#ways);
    if (this.#state) this.#markings.state(this.#state);
    this.#building.shut(this.#state?.closed_doors ?? []);
  }

  ways(ways: Ways): void {
    this.#ways = ways;
    this.#markings.ways(ways);
  }

  edges(edges: readonly Box[]): void {
    this.#edges = edges;
    this.#markings.edges(edges);
  }

  state(state: Drawn): void {
    if (state.closed_doors.join() !== this.#state?.closed_doors.join()) this.#building.shut(state.closed_doors);
    this.#state = state;
    this.#markings.state(state);
  }

  /** Puts everything where it is at one moment. */
  place({ shown, twist, seconds, moves }: Moment): void {
    this.#people.show(shown, moves);
    this.#chair.place(shown.pose, moves ? twist : [0, 0], seconds);
  }

  /** Shows what a camera is to see: its walls, its names; and no head before one's own eyes. */
  seen({ cut }: Pick<Sight, "cut">, camera: PerspectiveCamera, size: readonly [number, number] | null): void {
    this.#building.cut(cut);
    if (this.#chair.rider) this.#chair.rider.visible = cut !== null;
    this.#signs.group.visible = size !== null;
    if (size) this.#signs.arrange(camera, ...size);
  }

  dispose(): void {
    release(this.#content);
    this.scene.clear();
  }
}
