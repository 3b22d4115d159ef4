// The ride in a headset: the wearer sits in the chair. Any trigger is STOP.

import {
  CanvasTexture,
  Group,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  SRGBColorSpace,
  Vector3,
  type WebGLRenderer,
} from "three";
import { EYE_HEIGHT, headsetAxes, type Pose } from "./cameras";

/** True if this browser can show an immersive session. */
export async function hasHeadset(): Promise<boolean> {
  try {
    return (await navigator.xr?.isSessionSupported("immersive-vr")) ?? false;
  } catch {
    return false; // a policy forbids it
  }
}

/** Puts the headset's origin at the rider's eyes. */
export function sit(rig: Group, [x, y, heading]: Pose): void {
  const [right, up, back] = headsetAxes(heading).map((axis) => new Vector3(...axis)) as [Vector3, Vector3, Vector3];
  rig.matrix.copy(new Matrix4().makeBasis(right, up, back).setPosition(x, y, EYE_HEIGHT));
  rig.matrixAutoUpdate = false;
  rig.matrixWorldNeedsUpdate = true;
}

/** Opens a session, which ends with `ended`. */
export async function enter(renderer: WebGLRenderer, stop: () => void, ended: () => void): Promise<void> {
  const session = await navigator.xr!.requestSession("immersive-vr");
  session.addEventListener("select", stop);
  session.addEventListener("end", ended, { once: true });
  renderer.xr.setReferenceSpaceType("local");
  await renderer.xr.setSession(session);
}

/** Sign below the view that says how one stops, in the headset's frame. */
export function stopSign(colour: string): Group {
  const canvas = document.createElement("canvas");
  canvas.width = 512;
  canvas.height = 160;
  const context = canvas.getContext("2d")!;
  context.fillStyle = colour;
  context.beginPath();
  context.roundRect(0, 0, 512, 160, 28);
  context.fill();
  context.fillStyle = "#ffffff";
  context.textAlign = "center";
  context.font = "800 84px system-ui, sans-serif";
  context.fillText("STOP", 256, 84);
  context.font = "500 36px system-ui, sans-serif";
  context.fillText("press any trigger", 256, 134);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  const plate = new Mesh(new PlaneGeometry(0.32, 0.1), new MeshBasicMaterial({ map: texture, transparent: true }));
  plate.position.set(0, -0.42, -0.75);
  plate.rotation.x = -0.6;
  const sign = new Group();
  sign.add(plate);
  sign.visible = false;
  return sign;
}
