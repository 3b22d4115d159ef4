import { beforeEach, describe, expect, it } from "vitest";
import { reach } from "./reach";

beforeEach(() => (document.body.innerHTML = ""));

describe("reach", () => {
  it("lists what is marked, groups in one, the first ones first", () => {
    document.body.innerHTML = `
      <button data-scan>Mode</button>
      <button>not marked</button>
      <ul data-scan-group="Places"><li><button data-scan>Ward  A</button></li>
        <li><button data-scan aria-label="Ward B, 12 m">B</button></li></ul>
      <button data-scan="drive">Forward</button>
      <button data-scan="last">Stop</button>
      <button data-scan="first">Go on</button>`;
    const all = reach(document);
    expect(all.map((each) => each.label)).toEqual(["Go on", "Forward", "Mode", "Places", "Stop"]);
    expect(all[3]?.items?.map((each) => each.label)).toEqual(["Ward A", "Ward B, 12 m"]);
  });

  it("passes over what is hidden or cannot be used, and groups of one", () => {
    document.body.innerHTML = `
      <button data-scan disabled>a</button><button data-scan hidden>b</button>
      <button data-scan aria-disabled="true">c</button>
      <div data-scan-group="Alone"><button data-scan>d</button></div>`;
    expect(reach(document).map((each) => each.label)).toEqual(["d"]);
  });

  it("splits a long group in rows of about equal length, and loses nothing", () => {
    const buttons = Array.from({ length: 20 }, (_, n) => `<button data-scan>P${n}</button>`).join("");
    document.body.innerHTML = `<div data-scan-group="Places">${buttons}</div>`;
    const rows = reach(document)[0]?.items ?? [];
    // 20 in ⌈20 / 6⌉ = 4 rows of 5
    expect(rows.map((row) => row.label)).toEqual(["P0 to P4", "P5 to P9", "P10 to P14", "P15 to P19"]);
    expect(rows.flatMap((row) => row.items?.map((each) => each.label))).toEqual(
      Array.from({ length: 20 }, (_, n) => `P${n}`),
    );
    expect(rows[1]?.elements).toHaveLength(5);
  });

  it("reaches nothing but STOP behind an open dialog", () => {
    document.body.innerHTML = `<button data-scan>behind</button><button data-stop data-scan="last">STOP</button>
      <dialog open><button data-scan>in it</button></dialog>`;
    expect(reach(document).map((each) => each.label)).toEqual(["in it", "STOP"]);
  });

  it("knows an element again", () => {
    document.body.innerHTML = `<button data-scan>a</button>`;
    const [before] = reach(document);
    document.body.insertAdjacentHTML("afterbegin", `<button data-scan>b</button>`);
    expect(reach(document)[1]?.key).toBe(before?.key);
  });
});
