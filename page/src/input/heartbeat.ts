// Tells the chair ten times a second that this page is alive, and where the stick is.

import type { Link } from "../link";
import { deflection } from "./arbiter";

const EVERY = 100;

/** Begins it; returns what ends it. */
export function beat(link: Link): () => void {
  let seq = 0;
  const send = (): void => {
    link.send({
      type: "beat",
      seq: seq++,
      sent: performance.now(),
      ...deflection(),
      visible: document.visibilityState === "visible" && document.hasFocus(),
    });
  };
  const timer = setInterval(send, EVERY);
  return () => clearInterval(timer);
}
