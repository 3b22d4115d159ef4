// The map's colours, from the same CSS variables as the page's.

const NAMES = {
  free: "--map-free",
  wall: "--map-wall",
  unknown: "--map-unknown",
  text: "--map-text",
  ground: "--ground",
  route: "--route",
  without: "--without",
  preview: "--preview",
  plan: "--plan",
  chair: "--chair",
  onChair: "--on-chair",
  person: "--person",
  space: "--space",
  group: "--group",
  wish: "--wish",
  unwish: "--unwish",
  door: "--door",
  accent: "--accent",
  warn: "--warn",
  warnGround: "--warn-ground",
  wards: "--room-wards",
  toilets: "--room-toilets",
  food: "--room-food",
  care: "--room-care",
  ways: "--room-ways",
  other: "--room-other",
} as const;

export type Colours = Readonly<Record<keyof typeof NAMES, string>>;
export type Rgb = readonly [number, number, number];

export function coloursOf(element: Element): Colours {
  const style = getComputedStyle(element);
  const entries = Object.entries(NAMES).map(([name, variable]) => [
    name,
    style.getPropertyValue(variable).trim() || "#808080",
  ]);
  return Object.fromEntries(entries) as Colours;
}

/** Components of "#rrggbb". */
export function rgbOf(colour: string): Rgb {
  const n = Number.parseInt(colour.slice(1), 16);
  return [(n >> 16) & 255, (n >> 8) & 255, n & 255];
}
