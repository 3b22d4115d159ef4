// The WebSocket to the chair: it reconnects by itself and matches answers to questions.

import { t } from "./i18n/text.svelte";
import {
  VERSION,
  type Accepted,
  type FromPage,
  type Rejected,
  type ToPage,
  type TripPlans,
} from "./messages";

/** `outdated`: the chair speaks another version of the messages than this page. */
export type Status = "connecting" | "open" | "lost" | "sign-in" | "outdated";
export type Answer = Accepted | TripPlans | Rejected;
/** A message that carries a number, without it: `ask` gives it one. */
export type Question = Extract<FromPage, { id?: number }> extends infer Each
  ? Each extends { id?: number }
    ? Omit<Each, "id">
    : never
  : never;

const FIRST_WAIT = 250;
const LONGEST_WAIT = 4_000;
const ANSWER_WITHIN = 8_000;
/** A price is planned twice, by a process that leaves the processor to the one that drives. */
export const PRICE_WITHIN = 65_000;

/** What goes out by itself, and STOP, which has its own words. */
const UNASKED: ReadonlySet<FromPage["type"]> = new Set(["heartbeat", "echo", "stop"] as const);

type Listener = (message: ToPage) => void;
type Watcher = (status: Status) => void;

export class Link {
  status: Status = "connecting";
  #socket: WebSocket | null = null;
  #listeners = new Set<Listener>();
  #watchers = new Set<Watcher>();
  #open = new Map<number, (answer: Answer) => void>();
  #next = 1;
  #wait = FIRST_WAIT;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly address: string,
    /** Check that this page may connect; called when the socket was refused. */
    readonly allowed: () => Promise<boolean> = () => Promise.resolve(true),
  ) {}

  connect(): void {
    clearTimeout(this.#timer);
    if (this.#socket) return;
    const socket = new WebSocket(this.address);
    this.#socket = socket;
    socket.onmessage = (event: MessageEvent<string>) => this.#heard(JSON.parse(event.data) as ToPage);
    socket.onclose = () => void this.#closed(socket);
  }

  close(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = null;
    socket?.close();
  }

  /** Begins the connection anew, where there is one. */
  again(): void {
    const socket = this.#socket;
    if (!socket) return;
    void this.#closed(socket); // at once: whoever hears nothing may not answer a goodbye either
    socket.close();
  }

  /** Called where something that was asked for did not go out. */
  unsent: () => void = () => {};

  /** Says whether it went out; what cannot be sent now is not kept for later. */
  send(message: FromPage): boolean {
    if (this.#socket?.readyState !== WebSocket.OPEN) {
      if (!UNASKED.has(message.type)) this.unsent();
      return false;
    }
    this.#socket.send(JSON.stringify(message));
    return true;
  }

  /** Sends a question under a number of its own; the answer comes, or a refusal in its stead. */
  ask(question: Question, within = ANSWER_WITHIN): Promise<Answer> {
    const id = this.#next++;
    return new Promise((resolve) => {
      const refuse = (code: string, text: string): void =>
        answer({ type: "rejected", id, code, text });
      const timer = setTimeout(() => refuse("no_answer", t("link.noAnswer")), within);
      const answer = (given: Answer): void => {
        clearTimeout(timer);
        this.#open.delete(id);
        resolve(given);
      };
      this.#open.set(id, answer);
      if (!this.send({ ...question, id } as FromPage)) {
        refuse("link_lost", t("link.gone"));
      }
    });
  }

  /** Every message that comes; returns what ends it. */
  listen(listener: Listener): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }

  watch(watcher: Watcher): () => void {
    this.#watchers.add(watcher);
    watcher(this.status);
    return () => this.#watchers.delete(watcher);
  }

  #heard(message: ToPage): void {
    if (message.type === "welcome" && message.version !== VERSION) {
      this.close();
      this.#become("outdated");
      return;
    }
    if (message.type === "welcome") {
      this.#wait = FIRST_WAIT;
      this.#become("open");
    }
    if (
      message.type === "accepted" ||
      message.type === "trip_plans" ||
      message.type === "rejected"
    ) {
      this.#open.get(message.id)?.(message);
    }
    for (const listener of this.#listeners) listener(message);
  }

  async #closed(socket: WebSocket): Promise<void> {
    if (this.#socket !== socket) return;
    this.#socket = null;
    for (const [id, answer] of [...this.#open]) {
      answer({ type: "rejected", id, code: "link_lost", text: t("link.gone") });
    }
    if (this.status === "open") this.#become("lost");
    if (!(await this.allowed())) {
      this.#become("sign-in");
      return;
    }
    if (this.status !== "lost") this.#become("connecting");
    this.#timer = setTimeout(() => this.connect(), this.#wait);
    this.#wait = Math.min(2 * this.#wait, LONGEST_WAIT);
  }

  #become(status: Status): void {
    this.status = status;
    for (const watcher of this.#watchers) watcher(status);
  }
}

function address(): string {
  return `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/ws`;
}

/** Without an answer from the server the link is broken, not forbidden. */
async function signedIn(): Promise<boolean> {
  try {
    return (await fetch("/api/me")).status !== 401;
  } catch {
    return true;
  }
}

export const link = new Link(address(), signedIn);
