// English: the catalogue that says which texts there are.

import { chair } from "./en/chair";
import { rider } from "./en/rider";
import { therapist } from "./en/therapist";

export const en = { ...rider, ...chair, ...therapist } as const;
export type Key = keyof typeof en;
