"""Speed of the rider's page in Chromium without a graphics card: frames, first load, key to wheels.

    python benchmarks/page.py                # all figures
    python benchmarks/pictures.py            # the pictures of the documents

``cohelm drive`` runs beside it on the hospital floor. Frames are counted by
``requestAnimationFrame`` while the chair follows its path. The first load is the number of
transmitted bytes with an empty cache. Key to wheels is the time from the key press in the browser
to the command that follows it, by the chair's clock.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, expect, sync_playwright

CHROMIUM = "/usr/bin/chromium"
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"]
SIZES = {"phone": (360, 740), "tablet": (820, 1180), "desktop": (1440, 900)}
WINDOWS = (
    (320, 568), (360, 640), (390, 844), (640, 400), (844, 390), (1024, 600), (1180, 820),
    (1920, 1080),
)  # fmt: skip
"""Sizes that the page is looked at in, px: phones, 200 % zoom on 1280 x 800, tablets, a desktop."""
LOOKS: dict[str, dict[str, Any]] = {
    "light": {"color_scheme": "light", "contrast": "no-preference", "forced_colors": "none"},
    "dark": {"color_scheme": "dark", "contrast": "no-preference", "forced_colors": "none"},
    "contrast": {"color_scheme": "light", "contrast": "more", "forced_colors": "none"},
    "forced": {"color_scheme": "dark", "contrast": "no-preference", "forced_colors": "active"},
}
LONG_NAMES = """
const short = "Ward ", long = "Neurologische Frührehabilitation, Station ";
const { parse } = JSON, { send } = WebSocket.prototype;
JSON.parse = (text, ...more) => parse(text.replaceAll(short, long), ...more);
WebSocket.prototype.send = function (text) { send.call(this, text.replaceAll(long, short)); };
"""
"""The names of wards on a page are long, and the chair does not notice."""
SECONDS = 8.0
"""Time for which frames are counted, s."""
PRESSES = 150
START = re.compile("^(Start|Start this trip|Change to this trip)$")
GO_ON = re.compile("^Go on( to .*)?$")
FRAMES = """
seconds => new Promise((done) => {
  const at = [];
  requestAnimationFrame(function frame(now) {
    at.push(now);
    if (now - at[0] < 1000 * seconds) requestAnimationFrame(frame);
    else done(at);
  });
})
"""


def main() -> int:
    """Print all figures."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with served(people=30) as (address, _):
            first_load(browser, address)
            for name, (width, height) in SIZES.items():
                frames(browser, address, name, width, height)
        with served(people=12) as (address, _):
            keys(browser, address)
    return 0


@contextlib.contextmanager
def served(people: int, *options: str) -> Iterator[tuple[str, str]]:
    """Start a ride among a number of people; yields the page's address, the therapist's token.

    options: further ones of ``cohelm drive``.
    """
    with tempfile.TemporaryDirectory() as folder:
        program = subprocess.Popen(  # own program, fixed arguments
            [
                *(sys.executable, "-m", "cohelm", "drive", "hospital", "--port", "0"),
                *("--people", str(people), "--data", folder, *options),
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            said = ""
            for line in program.stdout or ():
                said += line
                if "Ctrl-C" in line:
                    break
            address = re.search(r"drive +(http://\S+?)/?\n", said)[1]
            token = re.search(r"therapist#token=(\S+)", said)[1]
            while not health(address)["ready"]:
                time.sleep(1.0)
            yield address, token
        finally:
            program.send_signal(signal.SIGINT)
            program.wait(60)


def health(address: str) -> dict[str, Any]:
    """Health report of the program."""
    with urllib.request.urlopen(f"{address}/api/health", timeout=10) as answer:  # our own
        found: dict[str, Any] = json.load(answer)
        return found


@contextlib.contextmanager
def opened(
    browser: Browser,
    address: str,
    width: int,
    height: int,
    words: str = "No driver.",
    **more: Any,
) -> Iterator[Page]:
    """Open a new page that is connected to the chair, and says these words."""
    context = browser.new_context(viewport={"width": width, "height": height}, **more)
    page = context.new_page()
    page.set_default_timeout(60_000)
    page.goto(address)
    expect(page.get_by_text(words)).to_be_visible(timeout=60_000)
    yield page
    context.close()


def show(page: Page, panel: str) -> None:
    """Open a panel, unless it is open."""
    tab = page.get_by_role("navigation").get_by_role("button", name=panel, exact=True)
    if tab.get_attribute("aria-expanded") != "true":
        tab.click()


def take(page: Page) -> None:
    """Drive from this page, and confirm if the page asks for it."""
    page.get_by_role("button", name="Drive from this screen").click()
    page.wait_for_timeout(700)
    go_on = page.get_by_role("button", name=GO_ON)
    if go_on.count() and go_on.get_attribute("aria-disabled") != "true":
        go_on.click()
        page.wait_for_timeout(300)


def look_at(page: Page, place: str) -> None:
    """Choose a place, and wait for the overview of the trip."""
    show(page, "Go to")
    field = page.get_by_role("searchbox")
    field.fill(place)
    field.press("Enter")
    start = page.get_by_role("button", name=START)
    expect(start).to_have_attribute("aria-disabled", "false", timeout=60_000)


def go(page: Page, place: str) -> None:
    """Start a trip to a place."""
    look_at(page, place)
    page.get_by_role("button", name=START).click()
    page.wait_for_timeout(500)


def ride(page: Page, seconds: float) -> None:
    """Drive for a time, confirm all requests, and wait until the chair moves."""
    go_on = page.get_by_role("button", name=GO_ON)
    end = time.monotonic() + seconds
    for _ in range(400):
        page.wait_for_timeout(300)
        if go_on.count() and go_on.get_attribute("aria-disabled") != "true":
            go_on.click()
        moves = "m/s" in page.locator(".numbers").inner_text()
        if time.monotonic() > end and moves and not page.locator(".why").is_visible():
            return
    raise TimeoutError("the chair does not drive")


def release(page: Page) -> None:
    """End driving from this page, so that the next page can drive."""
    page.get_by_role("button", name="STOP", exact=True).click()
    page.get_by_role("button", name="Mode: ").click()
    page.get_by_role("button", name="Stop driving from this screen").click()
    page.wait_for_timeout(500)


def first_load(browser: Browser, address: str) -> None:
    """Measure the transmitted bytes of the driver's and the therapist's page."""
    for path in ("/", "/therapist"):
        context = browser.new_context()
        page = context.new_page()
        sizes: list[int] = []
        page.on(
            "requestfinished",
            lambda request, sizes=sizes: sizes.append(request.sizes()["responseBodySize"]),
        )
        page.goto(address + path)
        page.wait_for_timeout(2000)
        print(f"first load of {path}: {sum(sizes) / 1000:.1f} kB in {len(sizes)} requests")
        context.close()


def frames(browser: Browser, address: str, name: str, width: int, height: int) -> None:
    """Measure the frame rate while the chair drives among people."""
    with opened(browser, address, width, height) as page:
        take(page)
        go(page, "Ward 4" if name != "tablet" else "Cafeteria")
        page.wait_for_timeout(3000)
        at = np.array(page.evaluate(FRAMES, SECONDS))
        gaps = np.diff(at)
        print(
            f"{name}, {width} x {height}: {1000.0 / gaps.mean():.0f} frames/s,"
            f" gaps median {np.median(gaps):.0f} ms, p99 {np.percentile(gaps, 99):.0f} ms;"
            f" {page.locator('.numbers').inner_text()}"
        )
        release(page)


def keys(browser: Browser, address: str) -> None:
    """Measure the delay from a key in the browser to the wheels."""
    with opened(browser, address, 1280, 800) as page:
        beats: list[dict[str, Any]] = []
        states: list[dict[str, Any]] = []
        page.on("websocket", lambda socket: listen(socket, beats, states))
        page.reload()
        expect(page.get_by_text("No driver.")).to_be_visible(timeout=60_000)
        epoch = page.evaluate("performance.timeOrigin") / 1000.0 - time.time() + time.monotonic()
        take(page)
        page.evaluate("document.activeElement.blur()")
        page.evaluate("window.pressed = []")
        page.evaluate(
            "addEventListener('keydown', ({ timeStamp }) => pressed.push(timeStamp), true)"
        )
        for k in range(PRESSES):
            key = ("ArrowLeft", "ArrowRight")[k % 2]
            page.keyboard.down(key)
            page.wait_for_timeout(150 + 13 * (k % 7))
            page.keyboard.up(key)
            page.wait_for_timeout(120 + 11 * (k % 5))
        took = [wheels(at, beats, states, epoch) for at in page.evaluate("pressed")]
    found = 1e3 * np.array([each for each in took if each is not None])
    print(
        f"key to wheels over {len(found)} presses: median {np.median(found):.0f} ms,"
        f" p99 {np.percentile(found, 99):.0f} ms"
    )


def listen(socket: Any, beats: list[dict[str, Any]], states: list[dict[str, Any]]) -> None:
    """Record the messages in both directions."""
    socket.on("framesent", lambda text: '"heartbeat"' in text and beats.append(json.loads(text)))
    socket.on("framereceived", lambda text: '"state"' in text and states.append(json.loads(text)))


def wheels(
    pressed: float, beats: list[dict[str, Any]], states: list[dict[str, Any]], epoch: float
) -> float | None:
    """Delay from a key to the wheels, s; None where the chair did not follow it."""
    told = next((each for each in beats if each["sent"] >= pressed and each["left"]), None)
    if told is None or told["sent"] > pressed + 120.0:
        return None
    for state in states:
        if state["heartbeat"] >= told["seq"]:
            return float(state["clock"] - epoch - pressed / 1000.0)
    return None


if __name__ == "__main__":
    sys.exit(main())
