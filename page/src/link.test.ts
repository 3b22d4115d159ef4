import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { Link, PRICE_WITHIN, type Status } from "./link";
import { VERSION, type ToPage } from "./messages";

class Socket {
  static readonly OPEN = 1;
  static all: Socket[] = [];
  readyState = Socket.OPEN;
  sent: { type: string; id?: number }[] = [];
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor(readonly address: string) {
    Socket.all.push(this);
  }
  send(text: string): void {
    this.sent.push(JSON.parse(text) as { type: string; id?: number });
  }
  close(): void {
    this.readyState = 3;
    this.onclose?.();
  }
  hear(message: Partial<ToPage>): void {
    this.onmessage?.({ data: JSON.stringify({ ...(message.type === "welcome" && { version: VERSION }), ...message }) });
  }
}

const newest = (): Socket => Socket.all[Socket.all.length - 1]!;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("WebSocket", Socket);
  Socket.all = [];
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("the link", () => {
  it("is open only once the chair has welcomed the page", () => {
    const link = new Link("ws://here");
    const seen: Status[] = [];
    link.watch((status) => seen.push(status));
    link.connect();
    newest().hear({ type: "welcome" });
    expect(seen).toEqual(["connecting", "open"]);
  });

  it("comes back by itself, and says meanwhile that it is lost", async () => {
    const link = new Link("ws://here");
    link.connect();
    newest().hear({ type: "welcome" });
    newest().close();
    expect(link.status).toBe("lost");
    await vi.advanceTimersByTimeAsync(300);
    expect(Socket.all).toHaveLength(2);
    newest().hear({ type: "welcome" });
    expect(link.status).toBe("open");
  });

  it("waits longer from time to time, but never for long", async () => {
    const link = new Link("ws://here");
    link.connect();
    for (let k = 0; k < 8; k++) {
      newest().close();
      await vi.advanceTimersByTimeAsync(4_000);
      expect(Socket.all).toHaveLength(k + 2);
    }
    newest().close();
    await vi.advanceTimersByTimeAsync(1_000);
    expect(Socket.all).toHaveLength(9);
  });

  it("asks for a sign-in instead of knocking on", async () => {
    const link = new Link("ws://here", () => Promise.resolve(false));
    link.connect();
    newest().close();
    await vi.advanceTimersByTimeAsync(10_000);
    expect(link.status).toBe("sign-in");
    expect(Socket.all).toHaveLength(1);
  });

  it("gives each answer to its own question", async () => {
    const link = new Link("ws://here");
    link.connect();
    newest().hear({ type: "welcome" });
    const first = link.ask({ type: "set_goal", place: "Ward 4" });
    const second = link.ask({ type: "set_pace", pace: "slow" });
    const [a, b] = newest().sent.map(({ id }) => id!);
    newest().hear({ type: "rejected", id: b!, code: "no", text: "No." });
    newest().hear({ type: "accepted", id: a! });
    expect((await first).type).toBe("accepted");
    expect((await second).type).toBe("rejected");
  });

  it("leaves no question without an answer", async () => {
    const link = new Link("ws://here");
    link.connect();
    newest().hear({ type: "welcome" });
    const cut = link.ask({ type: "set_pace", pace: "slow" });
    newest().close();
    expect(await cut).toMatchObject({ type: "rejected", code: "link_lost" });
    expect(await link.ask({ type: "set_pace", pace: "slow" })).toMatchObject({ code: "link_lost" });
  });

  it("waits as long as a question takes, and then says so", async () => {
    const link = new Link("ws://here");
    link.connect();
    newest().hear({ type: "welcome" });
    const heard = vi.fn();
    void link.ask({ type: "set_pace", pace: "slow" }).then(heard);
    const dear = link.ask({ type: "plan_trip", point: [1, 2], wishes: [] }, PRICE_WITHIN);
    await vi.advanceTimersByTimeAsync(PRICE_WITHIN - 1_000);
    expect(heard).toHaveBeenCalledExactlyOnceWith(expect.objectContaining({ code: "no_answer" }));
    newest().hear({ type: "trip_plans", id: newest().sent[1]!.id! });
    expect((await dear).type).toBe("trip_plans");
  });

  it("begins anew without waiting for the old one's goodbye, and heeds it no more", async () => {
    const link = new Link("ws://here");
    link.connect();
    const old = newest();
    old.hear({ type: "welcome" });
    old.close = () => undefined;
    const cut = link.ask({ type: "set_pace", pace: "slow" });
    link.again();
    expect(await cut).toMatchObject({ code: "link_lost" });
    await vi.advanceTimersByTimeAsync(300);
    expect(Socket.all).toHaveLength(2);
    newest().hear({ type: "welcome" });
    old.onclose?.();
    expect(link.status).toBe("open");
  });

  it("does not drive a chair that speaks another version", async () => {
    const link = new Link("ws://here");
    const heard = vi.fn();
    link.listen(heard);
    link.connect();
    newest().hear({ type: "welcome", version: VERSION + 1 } as Partial<ToPage>);
    expect(link.status).toBe("outdated");
    expect(heard).not.toHaveBeenCalled();
    expect(newest().readyState).toBe(3);
    await vi.advanceTimersByTimeAsync(10_000);
    expect(Socket.all).toHaveLength(1);
  });

  it("keeps nothing for later that it cannot send now", () => {
    const link = new Link("ws://here");
    expect(link.send({ type: "stop" })).toBe(false);
    link.connect();
    newest().hear({ type: "welcome" });
    expect(newest().sent).toEqual([]);
  });
});
