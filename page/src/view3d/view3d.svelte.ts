// State of the 3-D view; small, for it is loaded with the page.

import type { CameraName } from "./cameras";

/** `loading`: asked for, the map still shows; `failed`: the map stays, with a reason. */
export type View3dStatus = "off" | "loading" | "on" | "failed";

class View3d {
  status = $state<View3dStatus>("off");
  camera = $state<CameraName>("behind");
  /** Distance of the camera as a factor. */
  zoom = $state(1);
  /** Why it does not show; empty: it does. */
  trouble = $state("");
  headsetTrouble = $state("");
  /** Opens a session in a headset; null: this browser has none. */
  enterHeadset = $state.raw<(() => Promise<void>) | null>(null);
  readonly open = $derived(this.status !== "off");

  toggle(): void {
    if (this.open) this.close();
    else this.#begin();
  }

  /** The first frame was drawn. */
  ready(): void {
    if (this.status === "loading") this.status = "on";
  }

  close(): void {
    this.trouble = this.headsetTrouble = "";
    this.status = "off";
  }

  failed(why: string): void {
    this.trouble = why;
    this.status = "failed";
  }

  /** Who wants less motion begins with the camera that does not turn. */
  #begin(): void {
    this.status = "loading";
    this.zoom = 1;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.camera = "above";
  }
}

export const view3d = new View3d();
