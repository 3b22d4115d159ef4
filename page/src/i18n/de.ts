// German: a text for every key of the English catalogue, or this does not compile.

import { chair } from "./de/chair";
import { map } from "./de/map";
import { rider } from "./de/rider";
import { riders } from "./de/riders";
import { status } from "./de/status";
import { therapist } from "./de/therapist";
import { view3d } from "./de/view3d";
import type { Key } from "./en";

export const de: Readonly<Record<Key, string>> = { ...rider, ...chair, ...status, ...map, ...therapist, ...riders, ...view3d };
