// A few words on a coloured ground, about a point of the map.

const FONT = "600 14px system-ui, sans-serif";
/** Height of a badge, and the room on both sides of its words together, px. */
export const HEIGHT = 24;
const PADDING = 14;

export function badge(
  context: CanvasRenderingContext2D,
  text: string,
  x: number,
  y: number,
  ground: string,
  colour: string,
): void {
  const wide = badgeWidth(context, text);
  context.fillStyle = ground;
  context.beginPath();
  context.roundRect(x - wide / 2, y - HEIGHT / 2, wide, HEIGHT, HEIGHT / 2);
  context.fill();
  context.fillStyle = colour;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, x, y + 0.5);
}

export function badgeWidth(context: CanvasRenderingContext2D, text: string): number {
  context.font = FONT;
  return context.measureText(text).width + PADDING;
}
