// Light of the view: a sky, what the floor throws back, and a lamp aside.

import { Color, DirectionalLight, HemisphereLight, Vector3 } from "three";
import type { Colours } from "../map/palette";

/** Sky and lamp, of which a surface that faces up has its own colour: together about π. */
const SKY = 2.45;
const LAMP = 0.85;
const TOWARDS_LAMP = new Vector3(-0.5, -0.75, 1.2);
const LAMP_COLOUR = new Color("#fff6e8");

export function lights(colours: Colours): [HemisphereLight, DirectionalLight] {
  const sky = new HemisphereLight(new Color("#ffffff"), below(colours), SKY);
  sky.position.set(0, 0, 1);
  const lamp = new DirectionalLight(LAMP_COLOUR, LAMP);
  lamp.position.copy(TOWARDS_LAMP);
  return [sky, lamp];
}

/** Light on a surface with a normal, as three.js computes it for each pixel of a Lambert material.
 *
 * Flat walls have it in their colours, which costs a processor that draws far less. */
export function lightOn(normal: readonly [number, number, number], colours: Colours): Color {
  const up = 0.5 * normal[2] + 0.5;
  const light = below(colours).lerp(new Color("#ffffff"), up).multiplyScalar(SKY);
  const facing = Math.max(0, new Vector3(...normal).dot(TOWARDS_LAMP.clone().normalize()));
  return light.add(LAMP_COLOUR.clone().multiplyScalar(LAMP * facing)).multiplyScalar(1 / Math.PI);
}

function below(colours: Colours): Color {
  return new Color(colours.free).lerp(new Color(colours.wall), 0.3);
}
