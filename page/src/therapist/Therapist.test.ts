import { fireEvent, render, screen, within } from "@testing-library/svelte";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { SessionSummary } from "./api";
import Learned from "./Learned.svelte";
import Sessions from "./Sessions.svelte";
import SignIn from "./SignIn.svelte";

const RIDE = {
  id: "20260131-142530-r1", started: "2026-01-31T14:25:30+00:00", seed: 0, destination: "Ward A",
  outcome: "arrived", duration: 61, length: 34, modes: { shared: 61 }, devices: { keys: 20 }, wishes: 1,
  limits: [{ time: 0, limits: { max_speed: 1, max_acceleration: 0.6, min_distance: 0.75 } }], stops: [{ time: 5, duration: 2, code: "x", text: "Somebody was near." }], rating: 4,
  measures: { min_distance: 0.6 }, error: "",
} as const;
const SESSION = {
  session: { id: "20260131-142530", started: RIDE.started, scene: "hospital", robot: "chair", simulation: true },
  rides: [RIDE],
} as unknown as SessionSummary;

/** Answer of the server by method and path; null: none. */
let answers: Record<string, [number, unknown]>;
let asked: string[];

beforeEach(() => {
  asked = [];
  vi.stubGlobal("fetch", async (path: string, { method }: RequestInit) => {
    asked.push(`${method} ${path}`);
    const [status, said] = answers[`${method} ${path}`] ?? [404, null];
    return new Response(JSON.stringify(said), { status });
  });
  // jsdom knows dialogs, but not how to show them
  HTMLDialogElement.prototype.show = function () {
    this.open = true;
  };
  HTMLDialogElement.prototype.close = function () {
    this.open = false;
  };
});
afterEach(() => vi.unstubAllGlobals());

describe("sessions", () => {
  it("show rides with their measures, map, stops and exports", async () => {
    answers = { "GET /api/sessions": [200, [SESSION]] };
    render(Sessions);
    await fireEvent.click(await screen.findByText(/hospital, one ride/));
    expect(screen.getByText(/^Ride 1, \d+:\d+.*: Ward A$/)).toBeTruthy();
    expect(screen.getByText("Nearest person 0.60 m: closer than the target of 0.75 m.")).toBeTruthy();
    expect(screen.queryByText("Somebody was near.")).toBeNull(); // details are folded
    const details = screen.getByText("Timeline, map, measures").closest("details")!;
    details.open = true;
    await fireEvent(details, new Event("toggle"));
    expect(screen.getByText("0.60 m")).toBeTruthy();
    expect(await screen.findByText("No timeline is stored for this ride.")).toBeTruthy();
    expect(screen.getByText("Somebody was near.")).toBeTruthy();
    expect(screen.getByRole("img", { hidden: true }).getAttribute("src")).toBe("/api/sessions/20260131-142530-r1.png");
    const links = screen.getAllByRole("link", { hidden: true }).map((each) => each.getAttribute("href"));
    expect(links).toEqual(["/api/sessions/20260131-142530.html", "/api/sessions/20260131-142530.csv"]);
  });

  it("wait for the measures of a ride that has just ended", async () => {
    const fresh = { ...SESSION, rides: [{ ...RIDE, measures: {}, limits: [] }] };
    answers = { "GET /api/sessions": [200, [fresh]] };
    render(Sessions);
    await fireEvent.click(await screen.findByText(/hospital, one ride/));
    const details = screen.getByText("Timeline, map, measures").closest("details")!;
    details.open = true;
    await fireEvent(details, new Event("toggle"));
    expect(screen.getByText("Being worked out. This takes some seconds.")).toBeTruthy();
    expect(asked).not.toContain("GET /api/sessions/20260131-142530-r1.timeline.json");
    answers = { "GET /api/sessions": [200, [SESSION]] };
    expect(await screen.findByText("0.60 m", {}, { timeout: 5000 })).toBeTruthy();
    expect(screen.queryByText(/Being worked out/)).toBeNull();
    expect(asked).toContain("GET /api/sessions/20260131-142530-r1.timeline.json");
  });

  it("show the last ride first", async () => {
    const rides = [RIDE, { ...RIDE, id: "20260131-142530-r2", destination: "Ward B" }];
    answers = { "GET /api/sessions": [200, [{ ...SESSION, rides }]] };
    render(Sessions);
    await fireEvent.click(await screen.findByText(/hospital, 2 rides/));
    const titles = screen.getAllByRole("heading", { level: 3, hidden: true }).map((each) => each.textContent);
    expect(titles.map((each) => each?.replace(/,.*:/, ""))).toEqual(["Ride 2 Ward B", "Ride 1 Ward A"]);
  });

  it("are deleted only after asking once more", async () => {
    answers = { "GET /api/sessions": [200, [SESSION]], "DELETE /api/sessions": [200, { deleted: 1 }] };
    render(Sessions);
    await screen.findByText(/hospital/);
    await fireEvent.click(screen.getByRole("button", { name: "Delete all…" }));
    const dialog = within(screen.getByRole("dialog"));
    await fireEvent.click(dialog.getByRole("button", { name: "Cancel" }));
    expect(asked).not.toContain("DELETE /api/sessions");
    await fireEvent.click(screen.getByRole("button", { name: "Delete all…" }));
    answers["GET /api/sessions"] = [200, []];
    await fireEvent.click(dialog.getByRole("button", { name: "Delete all" }));
    expect(await screen.findByText("One session was deleted.")).toBeTruthy();
    expect(await screen.findByText(/No sessions yet/)).toBeTruthy();
  });

  it("say why they cannot be read", async () => {
    answers = { "GET /api/sessions": [403, { code: "therapist_only", text: "only the therapist may do this" }] };
    render(Sessions);
    expect((await screen.findByRole("alert")).textContent).toBe("Only the therapist may do this.");
  });
});

describe("what is learned", () => {
  const NOTHING = { tight_speed: 0.8, turn_share: 1, steadiness: 1, rides: { tight_speed: 0 }, since: "" };

  it("is shown, and forgotten with one press", async () => {
    const learned = { ...NOTHING, tight_speed: 0.7, steadiness: 0.91, rides: { tight_speed: 1, steadiness: 3 } };
    answers = { "GET /api/response": [200, learned], "DELETE /api/response": [200, NOTHING] };
    const forgotten = vi.fn();
    render(Learned, { forgotten });
    expect(await screen.findByText("0.70 m/s")).toBeTruthy();
    expect(screen.getByText("(one ride)")).toBeTruthy();
    expect(screen.getByText("91 %")).toBeTruthy();
    await fireEvent.click(screen.getByRole("button", { name: "Forget" }));
    expect(await screen.findByText("0.80 m/s")).toBeTruthy();
    expect(screen.getByRole("status").textContent).toContain("Forgotten");
    expect(forgotten).toHaveBeenCalledOnce();
    expect((screen.getByRole("button", { name: "Forget" }) as HTMLButtonElement).disabled).toBe(true);
  });

  it("says why it cannot be forgotten", async () => {
    const learned = { ...NOTHING, rides: { tight_speed: 2 } };
    answers = { "GET /api/response": [200, learned], "DELETE /api/response": [403, { code: "therapist_only", text: "only the therapist may do this" }] };
    render(Learned, { forgotten: vi.fn() });
    await fireEvent.click(await screen.findByRole("button", { name: "Forget" }));
    expect((await screen.findByRole("alert")).textContent).toBe("Only the therapist may do this.");
    expect(screen.getByText("(2 rides)")).toBeTruthy();
  });
});

describe("sign-in", () => {
  const enter = async (): Promise<void> => {
    await fireEvent.input(screen.getByLabelText("Therapist’s token"), { target: { value: " abcd " } });
    await fireEvent.click(screen.getByRole("button", { name: "Sign in" }));
  };

  it("lets the therapist in", async () => {
    answers = { "POST /api/sign-in": [200, { role: "therapist" }] };
    const entered = vi.fn();
    render(SignIn, { entered });
    await enter();
    await vi.waitFor(() => expect(entered).toHaveBeenCalledOnce());
  });

  it.each([
    [200, { role: "driver" }, "That is the driver’s token."],
    [401, { code: "wrong_token", text: "that token does not open anything here" }, "That token does not open anything here."],
    [429, { code: "locked", text: "wait 30 s" }, "Wait 30 s."],
  ])("refuses with words (%i)", async (status, said, words) => {
    answers = { "POST /api/sign-in": [status, said] };
    const entered = vi.fn();
    render(SignIn, { entered });
    await enter();
    await vi.waitFor(() => expect(screen.getByRole("alert").textContent).toBe(words));
    expect(entered).not.toHaveBeenCalled();
  });
});
