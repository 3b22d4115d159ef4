import { link } from "../link";
import { Inputs } from "./inputs.svelte";

/** This page's hands on this chair. */
export const inputs = new Inputs(link);
