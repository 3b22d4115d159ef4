import { afterEach, describe, expect, it } from "vitest";
import { keepFocus } from "./focus";

const tick = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));
let end = (): void => undefined;
afterEach(() => end());

function page(): HTMLElement {
  document.body.innerHTML = `<main>
    <nav><button id="tab">Tab</button></nav>
    <section id="panel"><div id="list"><button id="place">Place</button></div><button id="other">Other</button></section>
    <div id="under"><p><button id="change">Change</button></p></div>
  </main>`;
  const main = document.querySelector("main")!;
  end = keepFocus(main, () => document.querySelector("nav"));
  return main;
}
const of = (id: string): HTMLElement => document.getElementById(id)!;

describe("the focus", () => {
  it.each([
    ["place", "list", "panel"], // the nearest part that is left
    ["change", "under", "NAV"], // nothing is left about it
  ])("of %s goes on when %s goes", async (id, gone, to) => {
    page();
    of(id).focus();
    of(gone).remove();
    await tick();
    expect(document.activeElement!.id || document.activeElement!.tagName).toBe(to);
  });

  it("goes on from a panel that is hidden and from a button that is disabled", async () => {
    page();
    of("place").focus();
    of("place").blur(); // a browser blurs what is hidden
    of("panel").hidden = true;
    await tick();
    expect(document.activeElement!.tagName).toBe("NAV");
    of("panel").hidden = false;
    of("place").focus();
    of("place").blur();
    (of("place") as HTMLButtonElement).disabled = true;
    await tick();
    expect(document.activeElement!.id).toBe("list");
  });

  it("is nobody's where its owner let it go, and is not taken from another element", async () => {
    page();
    of("place").focus();
    of("place").blur();
    of("change").remove();
    await tick();
    expect(document.activeElement).toBe(document.body);
    of("place").focus();
    of("tab").focus();
    of("list").remove();
    await tick();
    expect(document.activeElement).toBe(of("tab"));
  });
});
