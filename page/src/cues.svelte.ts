// Cues besides the picture: vibration, tones and speech. All are off until the rider switches them on.

import type { Direction } from "./around";
import { languageNow } from "./i18n/text.svelte";
import { isCentred, type Deflection } from "./input/deflection";

export interface CueSettings {
  readonly haptics: boolean;
  readonly tones: boolean;
  readonly speech: boolean;
  /** Of speech; 1 is the voice's own. */
  readonly rate: number;
  /** `voiceURI`; empty: the device's voice of the language. */
  readonly voice: string;
}

export const SILENT_CUES: CueSettings = { haptics: false, tones: false, speech: false, rate: 1, voice: "" };
const KEPT = "cohelm.cues";
/** Time between two cues of the same direction, ms (assumed). */
const AGAIN = 1_200;
const DEAD = 0.15;

export type Pushed = "free" | "narrow" | "blocked";

/** What is in the direction of the stick; null: the stick rests or nothing is known. */
export function pushedInto(ring: readonly Direction[], at: Deflection): Pushed | null {
  if (ring.length === 0 || isCentred(at, DEAD)) return null;
  const angle = Math.atan2(at.left, at.forward);
  const k = Math.round((angle / (2 * Math.PI)) * ring.length + ring.length) % ring.length;
  const { freedom } = ring[k]!;
  return freedom === "unseen" ? null : freedom;
}

export function keptCues(storage: () => Pick<Storage, "getItem"> = () => localStorage): CueSettings {
  try {
    const kept = JSON.parse(storage().getItem(KEPT) ?? "{}") as Record<string, unknown>;
    const rate = typeof kept["rate"] === "number" ? Math.min(2, Math.max(0.5, kept["rate"])) : 1;
    return {
      haptics: kept["haptics"] === true,
      tones: kept["tones"] === true,
      speech: kept["speech"] === true,
      rate,
      voice: typeof kept["voice"] === "string" ? kept["voice"] : "",
    };
  } catch {
    return SILENT_CUES;
  }
}

class Cues {
  settings = $state.raw<CueSettings>(keptCues());
  #audio: AudioContext | null = null;
  #last: Pushed | null = null;
  #at = -Infinity;

  change(settings: Partial<CueSettings>): void {
    this.settings = { ...this.settings, ...settings };
    if (!this.settings.speech) globalThis.speechSynthesis?.cancel();
    try {
      localStorage.setItem(KEPT, JSON.stringify(this.settings));
    } catch {
      // A device that keeps nothing is silent the next time.
    }
  }

  /** The stick is pushed into something: once when that begins, then from time to time. */
  push(into: Pushed | null, now: number): void {
    const again = into !== this.#last || now - this.#at >= AGAIN;
    this.#last = into;
    if (into === null || into === "free" || !again) return;
    this.#at = now;
    if (this.settings.haptics) vibrate(into);
    if (this.settings.tones) this.#tone(into === "blocked" ? 220 : 440, into === "blocked" ? 0.25 : 0.12);
  }

  say(text: string): void {
    const speech = globalThis.speechSynthesis;
    if (!this.settings.speech || !speech || !text) return;
    const said = new SpeechSynthesisUtterance(text);
    said.lang = languageNow();
    said.rate = this.settings.rate;
    const voice = speech.getVoices().find((each) => each.voiceURI === this.settings.voice);
    if (voice) said.voice = voice;
    speech.cancel(); // what is old is not worth hearing any more
    speech.speak(said);
  }

  #tone(pitch: number, seconds: number): void {
    this.#audio ??= new AudioContext();
    const audio = this.#audio;
    const [oscillator, gain] = [audio.createOscillator(), audio.createGain()];
    oscillator.frequency.value = pitch;
    gain.gain.setValueAtTime(0.15, audio.currentTime);
    gain.gain.exponentialRampToValueAtTime(0.001, audio.currentTime + seconds);
    oscillator.connect(gain).connect(audio.destination);
    oscillator.start();
    oscillator.stop(audio.currentTime + seconds);
  }
}

/** The device itself, and a gamepad that can. */
function vibrate(into: Pushed): void {
  navigator.vibrate?.(into === "blocked" ? [80, 60, 80] : 40);
  for (const pad of navigator.getGamepads?.() ?? []) {
    const strength = into === "blocked" ? 0.8 : 0.4;
    void pad?.vibrationActuator?.playEffect?.("dual-rumble", { duration: 120, strongMagnitude: strength });
  }
}

export const cues = new Cues();
