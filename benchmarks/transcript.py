"""Transcript of a whole trip as a screen reader tells it: what Tab comes to, and what is announced.

    python benchmarks/transcript.py              # into docs/trip-transcript.txt
    python benchmarks/transcript.py --into FILE

The trip is driven by keyboard alone: from an open page to a place, STOP and on, to the arrival.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import CDPSession, Page, expect, sync_playwright

from page import CHROMIUM, FLAGS, GO_ON, opened, served

LISTEN = """
window.said = [];
addEventListener("DOMContentLoaded", () => {
  const LIVE = "[role=status], [role=alert], [aria-live]";
  const last = new WeakMap();
  const look = () => {
    for (const each of document.querySelectorAll(LIVE)) {
      const shown = each.checkVisibility();
      const text = shown ? each.textContent.replace(/\\s+/g, " ").trim() : "";
      if (text === (last.get(each) ?? "")) continue;
      last.set(each, text);
      const urgent = each.matches("[role=alert], [aria-live=assertive]");
      if (text) window.said.push([urgent ? "alert" : "status", text]);
    }
  };
  new MutationObserver(look).observe(document, {
    subtree: true, childList: true, characterData: true, attributes: true,
  });
});
"""
STATES = {
    "expanded": "expanded",
    "pressed": "pressed",
    "checked": "checked",
    "disabled": "disabled",
}
MOST_TABS = 90


class Transcript:
    """Lines of a transcript: keys, the focus, announcements.

    Args:
        page: Page with ``LISTEN``.
        devtools: Its session, for names and roles as a screen reader gets them.
    """

    def __init__(self, page: Page, devtools: CDPSession) -> None:
        self.page, self._devtools = page, devtools
        self.lines: list[str] = []

    def title(self, text: str) -> None:
        """Begin a part."""
        self.lines += ["", f"## {text}"]

    def rest(self, seconds: float) -> None:
        """Let time pass, and write down what is announced."""
        for _ in range(max(1, round(seconds / 0.2))):
            self.page.wait_for_timeout(200)
            self.hear()

    def hear(self) -> None:
        """Write down what was announced since the last call."""
        for urgency, text in self.page.evaluate("window.said.splice(0)"):
            self.lines.append(f"  {urgency}: {text}")

    def press(self, key: str) -> None:
        """Press a key."""
        self.page.keyboard.press(key)
        self.lines.append(f"[{key}]")
        self.rest(0.4)

    def focused(self) -> str:
        """Name, role and state of the focus, in a screen reader's order."""
        handle = self._devtools.send("Runtime.evaluate", {"expression": "document.activeElement"})[
            "result"
        ]["objectId"]
        nodes = self._devtools.send(
            "Accessibility.getPartialAXTree", {"objectId": handle, "fetchRelatives": False}
        )["nodes"]
        return _read_out(nodes[0])

    def order(self) -> None:
        """Go once round the page with Tab, and write down what it comes to."""
        # From the top of the page, wherever the focus was.
        # A focus that was lost with its button leaves Tab where that was; a new one moves it.
        self.page.evaluate(
            "const top = document.createElement('span'); top.tabIndex = -1;"
            "document.body.prepend(top); top.focus(); top.remove()"
        )
        first = ""
        for _ in range(MOST_TABS):
            self.page.keyboard.press("Tab")
            here = self.focused()
            at = self.page.evaluate(
                "[...document.querySelectorAll('*')].indexOf(document.activeElement)"
            )
            if at < 0 or f"{at}" == first or here.startswith("(no name)"):
                return  # the end of the page: the next Tab leaves it
            first = first or f"{at}"
            self.lines.append(f"  {here}")
            self.hear()

    def tab_to(self, *names: str) -> None:
        """Press Tab until one of these names has the focus."""
        for count in range(1, MOST_TABS + 1):
            self.page.keyboard.press("Tab")
            here = self.focused()
            if any(here.startswith((f"{name},", f"{name} to ")) for name in names):
                self.lines.append(f"[Tab × {count}] {here}")
                self.hear()
                return
        raise TimeoutError(f"Tab does not come to {names}")

    def until(self, words: str, seconds: float = 120.0) -> None:
        """Wait for an announcement; "Go on" is confirmed when the page asks for it."""
        heard = len(self.lines)
        for _ in range(round(seconds)):
            self.rest(1.0)
            if any(words in line for line in self.lines[heard:]):
                return
            if self.asks:
                self.tab_to("Go on")
                self.press("Enter")
        raise TimeoutError(f"{words!r} is not announced")

    @property
    def asks(self) -> bool:
        """True if the chair waits for "Go on"."""
        button = self.page.get_by_role("button", name=GO_ON)
        return bool(button.count()) and button.get_attribute("aria-disabled") != "true"


def trip(told: Transcript, place: str) -> None:
    """Drive to a place by keyboard alone."""
    told.title("The page opens: once round with Tab")
    told.rest(1.0)
    told.order()
    told.title(f"A trip to {place} is chosen")
    told.tab_to("Search for a place")
    told.page.keyboard.type(place)
    told.lines.append(f"[{place}]")
    told.press("Enter")
    start = told.page.get_by_role("button", name="Start", exact=True)
    expect(start).to_have_attribute("aria-disabled", "false", timeout=60_000)
    told.hear()
    told.title("The overview, with Tab")
    told.tab_to("Hide; the trip is kept")
    told.tab_to("Start")
    told.press("Enter")
    told.title("Under way: once round with Tab")
    told.rest(4.0)
    told.order()
    told.title("STOP, and on")
    told.press("Escape")
    told.rest(2.0)
    told.tab_to("Go on")
    told.press("Enter")
    told.title("To the arrival")
    told.until("You have arrived", 300.0)
    told.rest(3.0)


def main() -> int:
    """Write the transcript."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--into", type=Path, default=Path("docs/trip-transcript.txt"))
    options.add_argument("--place", default="Pharmacy")
    chosen = options.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with served(people=4) as (address, _), opened(browser, address, 1280, 800) as page:
            page.add_init_script(LISTEN)
            page.reload()
            page.get_by_text("No driver.").wait_for()
            told = Transcript(page, page.context.new_cdp_session(page))
            try:
                trip(told, chosen.place)
            finally:
                head = "What a screen reader tells of a trip; made by benchmarks/transcript.py."
                chosen.into.write_text("\n".join([head, *told.lines]) + "\n")
    print(f"{chosen.into}: {len(told.lines)} lines")
    return 0


def _read_out(node: dict[str, Any]) -> str:
    name = node.get("name", {}).get("value", "").strip() or "(no name)"
    parts = [name, node.get("role", {}).get("value", "")]
    for each in node.get("properties", []):
        value = each["value"].get("value")
        if each["name"] == "keyshortcuts" and value:
            parts.append(f"key {value}")
        if each["name"] in STATES and value not in {False, "false", None}:
            parts.append(STATES[each["name"]])
        elif each["name"] == "expanded":
            parts.append("collapsed")
    value = node.get("value", {}).get("value")
    described = node.get("description", {}).get("value", "")
    return ", ".join(
        [*parts, *([f"{value}"] if value else []), *([described] if described else [])]
    )


if __name__ == "__main__":
    sys.exit(main())
