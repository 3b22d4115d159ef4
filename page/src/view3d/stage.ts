// Renderer, camera and loop of the 3-D view.

import { Group, PerspectiveCamera, SRGBColorSpace, WebGLRenderer } from "three";
import { Motion, placed, type Shown } from "../map/motion";
import type { Colours } from "../map/palette";
import type { Box } from "../map/view";
import { followed, sightOf, type CameraName, type Sight } from "./cameras";
import { Detail } from "./detail";
import { enter, sit, stopSign } from "./headset";
import type { Ways } from "./markings";
import { release } from "./parts";
import { World, type Drawn, type Floor } from "./world";

/** More pixels than the page's own are drawn up to this ratio. */
const FINEST = 2;
/** Between two frames, ms; on a slow device half of the time is left to everything else. */
const FRAME = 16;
const LONGEST_PAUSE = 20;
/** A camera this near to where it goes has arrived, m. */
const ARRIVED = 0.002;
/** Names are arranged anew after this, ms. */
const ARRANGE = 200;

export interface Options {
  readonly canvas: HTMLCanvasElement;
  readonly floor: Floor;
  readonly colours: Colours;
  readonly stopColour: string;
  /** STOP, from a headset's trigger. */
  stop(): void;
  /** The first frame was drawn. */
  ready(): void;
  /** The graphics card took the picture away (true), or gives it back. */
  lost(is: boolean): void;
}

export class Stage {
  camera: CameraName = "behind";
  zoom = 1;
  /** Nothing moves between two states, and no camera flies. */
  still = false;
  readonly #fast = isFast();
  readonly #renderer: WebGLRenderer;
  readonly #world: World;
  readonly #eye = new PerspectiveCamera(50, 1, 0.12, 160);
  readonly #rig = new Group();
  readonly #sign: Group;
  readonly #motion = new Motion();
  readonly #ends = new AbortController();
  #detail = new Detail(1);
  #size: readonly [number, number] = [1, 1];
  #sight: Sight | null = null;
  #twist: readonly [number, number] = [0, 0];
  #dirty = true;
  #next = 0;
  #last = 0;
  #arranged = -Infinity;
  #drawn = false;

  constructor(readonly options: Options) {
    const { canvas, floor, colours } = options;
    this.#renderer = new WebGLRenderer({ canvas, antialias: this.#fast, powerPreference: "low-power" });
    this.#renderer.outputColorSpace = SRGBColorSpace;
    this.#renderer.xr.enabled = true;
    const most = this.#renderer.capabilities.maxTextureSize;
    this.#world = new World(floor, colours, { most, fast: this.#fast });
    this.#sign = stopSign(options.stopColour);
    this.#rig.add(this.#eye, this.#sign);
    this.#world.scene.add(this.#rig);
    this.#listen(canvas);
    this.#renderer.setAnimationLoop((now) => this.#frame(now));
  }

  /** Something changed that is to be seen, though nothing moves. */
  touch(): void {
    this.#dirty = true;
  }

  state(state: Drawn, now: number): void {
    if (placed(state)) this.#motion.put(state, now);
    this.#twist = [state.speed, state.turn_rate];
    this.#world.state(state);
    this.#dirty = true;
  }

  ways(ways: Ways): void {
    this.#world.ways(ways);
    this.#dirty = true;
  }

  edges(edges: readonly Box[]): void {
    this.#world.edges(edges);
    this.#dirty = true;
  }

  recolour(colours: Colours): void {
    this.#world.recolour(colours);
    this.#arranged = -Infinity;
    this.#dirty = true;
  }

  resize(width: number, height: number): void {
    if (width === 0 || height === 0) return;
    this.#size = [width, height];
    this.#detail = new Detail(Math.min(FINEST, devicePixelRatio));
    this.#scale();
  }

  async enterHeadset(): Promise<void> {
    this.#sign.visible = true;
    try {
      await enter(this.#renderer, this.options.stop, () => this.#leftHeadset());
    } catch (error) {
      this.#leftHeadset();
      throw error;
    }
  }

  /** Ends everything and frees what the graphics card holds. */
  dispose(): void {
    this.#ends.abort();
    void this.#renderer.xr.getSession()?.end().catch(() => undefined);
    this.#renderer.setAnimationLoop(null);
    release(this.#sign);
    this.#world.dispose();
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
  }

  #listen(canvas: HTMLCanvasElement): void {
    const { signal } = this.#ends;
    canvas.addEventListener("webglcontextlost", () => this.options.lost(true), { signal });
    canvas.addEventListener(
      "webglcontextrestored",
      () => {
        this.options.lost(false);
        this.#dirty = true;
      },
      { signal },
    );
  }

  #leftHeadset(): void {
    this.#sign.visible = false;
    this.#rig.matrixAutoUpdate = true;
    this.#rig.position.set(0, 0, 0);
    this.#rig.rotation.set(0, 0, 0);
    this.#sight = null;
    this.#scale();
  }

  #scale(): void {
    if (this.#renderer.xr.isPresenting) return;
    this.#renderer.setPixelRatio(this.#detail.ratio);
    this.#renderer.setSize(...this.#size, false);
    this.#eye.aspect = this.#size[0] / this.#size[1];
    this.#dirty = true;
  }

  #frame(now: number): void {
    const worn = this.#renderer.xr.isPresenting;
    const moving = this.#dirty || (!this.still && this.#motion.moving(now));
    if (this.still || !moving) this.#detail.pause();
    if (!worn && (now < this.#next || !moving)) return;
    const shown = this.#motion.at(now, this.still);
    if (!shown) return;
    const began = performance.now();
    const seconds = Math.min(0.1, (now - this.#last) / 1000);
    this.#last = now;
    this.#dirty = false;
    this.#world.place({ shown, twist: this.#twist, seconds, moves: !this.still });
    if (worn) this.#sit(shown);
    else this.#look(shown, now, seconds);
    this.#renderer.render(this.#world.scene, this.#eye);
    this.#next = now + Math.min(LONGEST_PAUSE, 2 * (performance.now() - began) - FRAME);
    if (!worn && this.#detail.drawn(now)) this.#scale();
    if (!this.#drawn) this.options.ready();
    this.#drawn = true;
  }

  #sit({ pose }: Shown): void {
    sit(this.#rig, pose);
    this.#world.seen({ cut: null }, this.#eye, null);
  }

  #look({ pose }: Shown, now: number, seconds: number): void {
    const to = sightOf(this.camera, pose, this.zoom);
    const sight = this.still ? to : followed(this.#sight, to, seconds);
    this.#sight = sight;
    if (Math.hypot(...sight.at.map((each, k) => each - to.at[k]!)) > ARRIVED) this.#dirty = true;
    const eye = this.#eye;
    eye.up.set(...sight.up);
    eye.position.set(...sight.at);
    eye.lookAt(...sight.look);
    eye.fov = sight.angle;
    eye.updateProjectionMatrix();
    eye.updateMatrixWorld();
    if (now - this.#arranged < ARRANGE) return;
    this.#arranged = now;
    this.#world.seen(sight, eye, this.#size);
  }
}

/** False where the picture is made by the processor. */
function isFast(): boolean {
  return !/swiftshader|llvmpipe|software|basic render/i.test(withContext(nameOf) ?? "software");
}

/** True if this browser draws in three dimensions. */
export function canDraw(): boolean {
  return withContext(() => true) ?? false;
}

function nameOf(context: WebGL2RenderingContext): string {
  const info = context.getExtension("WEBGL_debug_renderer_info");
  return String(context.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER));
}

/** Something of a context that is given back at once; null: there is none. */
function withContext<T>(of: (context: WebGL2RenderingContext) => T): T | null {
  const context = document.createElement("canvas").getContext("webgl2");
  const found = context && of(context);
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return found;
}
