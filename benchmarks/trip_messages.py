"""Messages of a whole trip, each checked against the chair's own state, on a slowed computer.

    python benchmarks/trip_messages.py --busy 2          # two busy processes beside it
    python benchmarks/trip_messages.py --busy 0 --into FILE

The page is read ten times a second from *Start* to the arrival, together with the states that came
to it. The rider presses nothing but *Start*, and *Go on* where the page asks for it. A message is
untrue if no state of the last seconds bears it out: what is shown stays to be read
(``page/src/reasonDisplay.ts``). A list of all messages with their durations is printed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from page import CHROMIUM, FLAGS, GO_ON, START, look_at, opened, served

Sample = dict[str, Any]
"""Instant of the page: its time ``at``, s, words by their place, and the newest ``state``."""

RECORD = """
window.samples = [];
let newest = null, came = 0, took = 0;
const Plain = window.WebSocket;
window.WebSocket = class extends Plain {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      if (typeof data !== "string" || !data.includes('"type":"state"')) return;
      const { type, plan, groups, true_people, free, offers, people, ...rest } = JSON.parse(data);
      if (rest.driver !== newest?.driver) took = performance.now();
      const held_for = (performance.now() - took) / 1000;
      newest = { ...rest, held_for, people: people.map(({ x, y }) => [x, y]) };
      came = performance.now();
    });
  }
};
const WORDS = {
  top: ".line .stands, .line .who strong", left: ".line .numbers", lost: ".banner .lost",
  aside: ".banner .aside", reason: ".banner .why", news: ".banner .news", slow: ".banner .slow",
  button: ".ready p", next: ".trip .next", to: ".trip .to", card: ".cards > .card:first-child > p",
};
setInterval(() => {
  if (!newest) return;
  const words = {};
  for (const [place, where] of Object.entries(WORDS)) {
    const shown = document.querySelector(where);
    words[place] = shown?.checkVisibility() ? shown.textContent.replace(/\\s+/g, " ").trim() : "";
  }
  const pressable = document.querySelector(".ready button[aria-disabled=false]");
  const now = performance.now();
  window.samples.push({
    at: now / 1000, age: (now - came) / 1000, words,
    asks: pressable ? pressable.textContent.trim() : "", state: newest,
  });
}, 100);
"""
LASTING = 2.5
"""A message may be true of any state of the last seconds, s: 1 s to be read, 0.4 s of gaps, the
time until a stop counts as one, twice 0.1 s of looking, and a slow browser."""
LASTING_SLOW = 3.6
"""The same of a slow computer, which is told of once it lasts 3 s, until it is over for 3 s."""
LONGEST = 1500.0
"""Time within which the trip must arrive, s."""
STILL = 0.05
"""Speed below which the chair stands, m/s."""
FIRST_BEAT = 1.0
"""Time within which the first heartbeat of a page that takes control is on its way, s."""
EFFECTS = {
    "Slowed down.": "too_close",
    "Driving very slowly.": "creeping",
    "Looking for another route.": "replanning",
    "Backing up a little.": "backing_up",
    "Please steer, or choose another destination.": "ask_rider",
}
"""What the page says of a reason whose cause it names."""


def main() -> int:
    """Drive, and print all messages; 1 if one was untrue or the trip hung."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--busy", type=int, default=2, help="processes that compute beside it")
    options.add_argument("--people", type=int, default=12)
    options.add_argument("--place", default="Cafeteria")
    options.add_argument("--into", type=Path, help="file for all samples, as JSON")
    chosen = options.parse_args()
    with (
        sync_playwright() as playwright,
        served(people=chosen.people) as (address, _),
        busy(chosen.busy),
    ):
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with opened(browser, address, 1280, 800) as page:
            samples, arrived = trip(page, chosen.place)
    if chosen.into:
        chosen.into.write_text(json.dumps(samples))
    return report(samples, arrived=arrived)


@contextlib.contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep processes computing without end."""
    beside = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        print(f"{count} busy processes; load of the computer before {os.getloadavg()[0]:.1f}")
        yield
    finally:
        for each in beside:
            each.kill()
            each.wait()


def trip(page: Page, place: str) -> tuple[list[Sample], bool]:
    """Drive to a place; returns all samples, and True if it arrived."""
    page.add_init_script(RECORD)
    page.reload()
    look_at(page, place)
    page.get_by_role("button", name=START).click()
    began = page.evaluate("performance.now() / 1000")
    go_on = page.get_by_role("button", name=GO_ON)
    while page.evaluate("performance.now() / 1000") < began + LONGEST:
        page.wait_for_timeout(1000)
        if page.get_by_text("You have arrived").first.is_visible():
            page.wait_for_timeout(4000)  # what is said after it counts, too
            return _since(page, began), True
        if go_on.count() and go_on.get_attribute("aria-disabled") != "true":
            go_on.click()
    return _since(page, began), False


def _since(page: Page, began: float) -> list[Sample]:
    samples: list[Sample] = page.evaluate("window.samples")
    return [each for each in samples if each["at"] >= began]


@dataclass
class Shown:
    """Message, its place on the page, and the samples through which it stood there."""

    place: str
    words: str
    samples: list[Sample]
    untrue: float = 0.0
    """Time for which no state of the last seconds bore it out, s."""

    @property
    def seconds(self) -> float:
        """Time for which it was shown, s."""
        return float(self.samples[-1]["at"] - self.samples[0]["at"] + 0.1)


def messages(samples: list[Sample]) -> list[Shown]:
    """All messages in the order in which they came; figures in them are left out."""
    found: list[Shown] = []
    for place in samples[0]["words"]:
        last: Shown | None = None
        for each in samples:
            words = re.sub(r"[\d.]+", "#", each["words"][place])
            if last and last.words == words:
                last.samples.append(each)
                continue
            last = Shown(place, words, [each])
            found.append(last)
    return sorted((each for each in found if each.words), key=lambda each: each.samples[0]["at"])


def check(shown: Shown, samples: list[Sample]) -> None:
    """Count the time for which a message was untrue."""
    law = LAWS[shown.place]
    lasting = LASTING_SLOW if shown.place == "slow" else LASTING
    for each in shown.samples:
        recent = [s for s in samples if each["at"] - lasting <= s["at"] <= each["at"]]
        if not any(law(each["words"][shown.place], s["state"]) for s in recent):
            shown.untrue += 0.1


def stands(state: Sample) -> bool:
    """Check that the chair neither drives nor turns."""
    return abs(state["speed"]) <= STILL and abs(state["turn_rate"]) <= STILL


def reason_is_true(words: str, state: Sample) -> bool:
    """Check a reason: it is the chair's own, and the cause that it names is there."""
    reason = state["reason"] or {"code": "", "text": ""}
    if "The door to" in words and not state["closed_doors"]:
        return False
    if words.startswith("A person is") and not _person_near(state):
        return False
    if words.endswith("Stopped.") and not stands(state):
        return False
    if words.endswith("Driving very slowly.") and stands(state):
        return False
    code = next((code for end, code in EFFECTS.items() if words.endswith(f" {end}")), "")
    if re.search(r"^(A |The door|Something).* (Stopped|Waiting)\.$", words):
        return reason["code"] in {"blocked", "no_safe_plan", "waiting"}
    return reason["code"] == code if code else words == reason["text"]


def top_is_true(words: str, state: Sample) -> bool:
    """Check the top line: who steers while the chair moves, else why it stands."""
    if words in {"You steer", "The chair steers", "You and the chair steer"}:
        authority = state["rider_authority"]
        who = {"You steer": authority > 0.8, "The chair steers": authority < 0.2}
        return not stands(state) and not state["arrived"] and who.get(words, True)
    if "connection" in words or "Connection" in words:
        # Between taking control and the first heartbeat nothing is lost.
        return bool(state["link"] == "no_heartbeat" and state["held_for"] > FIRST_BEAT)
    if words.startswith("Arrived"):
        return bool(state["arrived"]) or not state["goal"]
    return stands(state) and stand_is_true(words, state)


def stand_is_true(words: str, state: Sample) -> bool:
    """Check why it stands."""
    if words == "Ready: press “Go on”":
        return bool(state["link"] == "confirm" and not state["not_ready"])
    if words.startswith("Setting off"):
        return state["reason"] is None
    if words == "Standing for a moment":
        return state["reason"] is not None
    if words.startswith("Standing: ") and words.endswith("."):
        return held_is_true(words.removeprefix("Standing: "), state)
    if words.startswith(("Ready", "Standing")):
        return not (state["reason"] and state["link"] == "ready")
    return reason_is_true(words, state)


def held_is_true(words: str, state: Sample) -> bool:
    """Check what a standing chair names although its reason was too short to be displayed."""
    reason = state["reason"] or state["not_ready"]
    if reason is None or ("door" in words and not state["closed_doors"]):
        return False
    if words.startswith("A person is"):
        return _person_near(state)
    causes = ("A wall is close", "Something stands", "The door to", "A door is")
    return words.startswith(causes) or reason["text"].startswith(words)


def next_is_true(words: str, state: Sample) -> bool:
    """Check the next step of the trip."""
    left = state["remaining"]
    if words == "You are almost there":
        return left is not None and left < 3.5 and not state["not_ready"]
    if words == "Trip on hold":
        return state["not_ready"] is not None or state["reason"] is not None
    return left is not None or "planned" in words or "Planning" in words


def slows_for_person(state: Sample) -> bool:
    """Check that the chair is slow and a person is near."""
    return abs(state["speed"]) < 0.6 and _person_near(state)


def _person_near(state: Sample) -> bool:
    x, y, _ = state["pose"]
    return any((px - x) ** 2 + (py - y) ** 2 < 4.5**2 for px, py in state["people"])


LAWS: dict[str, Any] = {
    "top": top_is_true,
    "left": lambda words, state: (
        not stands(state) and ("slow for a person" not in words or slows_for_person(state))
    ),
    "lost": lambda *_: False,
    "aside": lambda words, state: "the simulation runs slower" not in words or state["rate"] < 1.0,
    "reason": reason_is_true,
    "news": lambda _, state: state["route_version"] > 0,
    "slow": lambda _, state: state["rate"] < 0.95,
    "button": lambda words, state: (
        (state["link"] == "confirm") == words.startswith(("Stopped", "Choose"))
        or state["not_ready"] is not None
    ),
    "next": next_is_true,
    "to": lambda _, state: state["goal"] is not None,
    "card": lambda words, state: not words.startswith("You have arrived") or not state["ride"],
}
"""For each place of the page: True if its words are true of a state."""


def report(samples: list[Sample], *, arrived: bool) -> int:
    """Print the messages and the figures."""
    minutes = (samples[-1]["at"] - samples[0]["at"]) / 60.0
    told = messages(samples)
    for each in told:
        check(each, samples)
        mark = f"UNTRUE for {each.untrue:.1f} s" if each.untrue > 0.05 else ""
        start = each.samples[0]["at"] - samples[0]["at"]
        print(f"{start:7.1f} s {each.place:7} {each.seconds:6.1f} s  {each.words}  {mark}")
    rates = [each["state"]["rate"] for each in samples]
    reasons = [each for each in told if _is_reason(each)]
    untrue = [each for each in told if each.untrue > 0.05]
    print(
        f"\n{'arrived' if arrived else 'NOT ARRIVED'} after {minutes:.1f} min,"
        f" time ran at {sum(rates) / len(rates):.2f} of real time, least {min(rates):.2f}\n"
        f"{len(told)} messages, {len(untrue)} untrue; {len(reasons)} reasons,"
        f" {len(reasons) / minutes:.1f} per minute, shortest"
        f" {min((each.seconds for each in reasons), default=0.0):.1f} s\n"
        f"longest stand {longest(samples, lambda each: stands(each['state'])):.1f} s,"
        f" longest without a state {max(each['age'] for each in samples):.1f} s\n"
        f"“Go on” waited for {total(samples, waited):.1f} s, unasked for at most"
        f" {longest(samples, lambda each: waited(each) and not each['asks']):.1f} s"
    )
    return int(bool(untrue) or not arrived)


def _is_reason(shown: Shown) -> bool:
    if shown.place == "reason":
        return True
    other = ("Ready", "Standing", "Setting off", "Arrived", "You steer", "The chair", "You and")
    return shown.place == "top" and not shown.words.startswith(other)


def waited(sample: Sample) -> bool:
    """Check that the chair waits for "Go on" and for nothing else."""
    state = sample["state"]
    trip_on = state["goal"] is not None and not state["arrived"]
    return bool(state["link"] == "confirm" and not state["not_ready"] and trip_on)


def total(samples: list[Sample], holds: Any) -> float:
    """Time for which something held, s."""
    return 0.1 * sum(bool(holds(each)) for each in samples)


def longest(samples: list[Sample], holds: Any) -> float:
    """Longest time for which something held without a break, s."""
    most, since = 0.0, None
    for each in samples:
        since = (each["at"] if since is None else since) if holds(each) else None
        most = max(most, each["at"] - since if since is not None else 0.0)
    return most


if __name__ == "__main__":
    sys.exit(main())
