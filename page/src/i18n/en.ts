// English: the catalogue that says which texts there are.

import { chair } from "./en/chair";
import { map } from "./en/map";
import { rider } from "./en/rider";
import { riders } from "./en/riders";
import { status } from "./en/status";
import { therapist } from "./en/therapist";
import { view3d } from "./en/view3d";

export const en = { ...rider, ...chair, ...status, ...map, ...therapist, ...riders, ...view3d } as const;
export type Key = keyof typeof en;
