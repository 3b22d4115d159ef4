"""Pictures of every state of the page, for the documents.

    python benchmarks/pictures.py              # into docs/images
    python benchmarks/pictures.py --into DIR
    python benchmarks/pictures.py --only windows --into DIR    # all sizes in all palettes

``cohelm drive`` runs beside it on the hospital floor.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Locator, Page, WebSocketRoute, expect, sync_playwright

from page import (
    CHROMIUM,
    FLAGS,
    GO_ON,
    LONG_NAMES,
    LOOKS,
    START,
    WINDOWS,
    go,
    look_at,
    opened,
    release,
    ride,
    served,
    show,
)  # fmt: skip

LARGEST = 150_000
"""Maximum size of a picture, bytes."""


def main() -> int:
    """Make all pictures."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--into", type=Path, default=Path("docs/images"))
    options.add_argument("--only", choices=[*PARTS], help="one part only")
    chosen = options.parse_args()
    chosen.into.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        with served(people=12) as (address, token):
            for name, part in PARTS.items():
                if chosen.only == name or (chosen.only is None and part is not windows):
                    part(browser, address, token, chosen.into)
    return 0


def connection(browser: Browser, address: str, _: str, folder: Path) -> None:
    """Make the pictures of a chair that starts up, and of a lost connection, also on a phone."""
    with opened(browser, address, 1280, 800) as page:
        show(page, "Simulation")
        page.get_by_role("button", name="Restart").click()
        expect(page.locator(".line")).to_contain_text("Starting up")
        keep(page, folder / "page-starting.png")
        expect(page.locator(".line")).not_to_contain_text("Starting up", timeout=60_000)
    for name, (width, height) in {"page-lost": (1280, 800), "page-phone-lost": (390, 844)}.items():
        context = browser.new_context(viewport={"width": width, "height": height})
        page, cables, cut = context.new_page(), list[WebSocketRoute](), threading.Event()

        def cable(socket: WebSocketRoute, cables: Any = cables, cut: Any = cut) -> None:
            if cut.is_set():
                socket.close()
            else:
                cables.append(socket.connect_to_server())
                cables.append(socket)

        page.route_web_socket("**/ws", cable)
        page.goto(address)
        expect(page.get_by_text("No driver.")).to_be_visible(timeout=60_000)
        go(page, "Ward 4")
        page.get_by_role("button", name="OK").first.click()
        ride(page, 4.0)
        cut.set()
        for each in cables:
            each.close()
        expect(page.get_by_text("Connection to the chair lost").first).to_be_visible()
        page.wait_for_timeout(600)
        keep(page, folder / f"{name}.png")
        context.close()
    with opened(browser, address, 1280, 800) as page:
        show(page, "Simulation")
        page.get_by_role("button", name="Restart").click()
        page.wait_for_timeout(3000)


def phones(browser: Browser, address: str, _: str, folder: Path) -> None:
    """Make the pictures of a phone: places, overview, trip."""
    with opened(browser, address, 390, 844, has_touch=True) as page:
        show(page, "Go to")
        keep(page, folder / "page-phone-places.png")
        set_off(page, "Ward 4", folder / "page-phone-overview.png", 9.0)
        keep(page, folder / "page-phone.png")
        release(page)
    with opened(browser, address, 820, 1180) as page:
        look_at(page, "Ward 4")
        page.get_by_role("button", name="Go via, avoid, draw").click()
        page.get_by_label("Choose a place").select_option("Laboratory")
        page.get_by_role("button", name="Go via here").click()
        expect(page.get_by_text("By way of Laboratory: +")).to_be_visible(timeout=60_000)
        keep(page, folder / "page-tablet.png")


def desktops(browser: Browser, address: str, _: str, folder: Path) -> None:
    """Make the pictures of a trip on a desktop, to its end, and of a shut door."""
    with opened(browser, address, 1280, 800) as page:
        set_off(page, "Cafeteria", folder / "page-overview.png", 6.0)
        keep(page, folder / "page-desktop.png")
        page.get_by_role("button", name="Legend").click()
        page.wait_for_timeout(400)
        keep(page, folder / "page-legend.png")
        page.get_by_role("button", name="Legend").first.click()
        page.get_by_role("button", name="STOP", exact=True).click()
        page.wait_for_timeout(1500)
        keep(page, folder / "page-stopped.png")
        until_arrival(page)
        keep(page, folder / "page-arrived.png")
        page.get_by_role("button", name="Skip").click()
        go(page, "Pharmacy")
        ride(page, 1.0)
        show(page, "Simulation")
        doors = page.get_by_role("button", name=re.compile(": open$"))
        while doors.count():
            doors.first.click()
            page.wait_for_timeout(150)
        go_on(page, lambda: page.locator(".line").filter(has_text="is shut").is_visible())
        keep(page, folder / "page-door.png")
        show(page, "Simulation")
        page.get_by_role("button", name="Restart").click()
        page.wait_for_timeout(3000)
        release(page)


def themes(browser: Browser, address: str, _: str, folder: Path) -> None:
    """Make the pictures of the other palettes, of one switch and of German."""
    with opened(browser, address, 1280, 800, color_scheme="dark") as page:
        go(page, "Ward 4")
        show(page, "Speed")
        ride(page, 6.0)
        keep(page, folder / "page-dark.png")
        release(page)
    with opened(browser, address, 1280, 800, contrast="more") as page:
        show(page, "Settings")
        page.get_by_label("One switch").check()
        go(page, "Ward 4")
        ride(page, 6.0)
        keep(page, folder / "page-high-contrast.png")
        release(page)
    with opened(browser, address, 1280, 800, locale="de-DE", words="Niemand fährt.") as page:
        page.get_by_role("button", name="Einstellungen").click()
        page.wait_for_timeout(400)
        keep(page, folder / "page-german.png")


def sessions(browser: Browser, address: str, token: str, folder: Path) -> None:
    """Make the pictures of the therapist's view and of a ride's timeline."""
    with opened(browser, address, 1280, 800) as page:
        go(page, "Laboratory")
        ride(page, 15.0)
        page.get_by_role("button", name="Cancel trip").click()
        release(page)
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    page.set_default_timeout(60_000)
    page.goto(f"{address}/therapist#token={token}")
    page.get_by_text("Target distance from people").wait_for()
    page.wait_for_timeout(2000)
    keep(page, folder / "therapist.png")
    page.locator("summary").first.click()
    page.get_by_text("Timeline, map, measures").last.click()
    slider = page.get_by_role("slider", name="Time in the ride")
    slider.wait_for()
    slider.fill("14")
    page.wait_for_timeout(1000)
    keep(page.get_by_role("region", name="Timeline"), folder / "page-timeline.png")
    context.close()


def windows(browser: Browser, address: str, token: str, folder: Path) -> None:
    """Make pictures of each state in all windows and palettes, in German and with long names."""
    context = browser.new_context(locale="de-DE", reduced_motion="reduce")
    context.add_init_script(LONG_NAMES)
    page = context.new_page()
    page.set_default_timeout(60_000)

    def shoot(state: str, prepare: Callable[[], None] = lambda: None) -> None:
        for width, height in WINDOWS:
            page.set_viewport_size({"width": width, "height": height})
            page.wait_for_timeout(200)
            prepare()
            for look, media in LOOKS.items():
                page.emulate_media(**media)
                page.wait_for_timeout(250)
                page.screenshot(path=folder / f"{state}-{width}x{height}-{look}.png")
        print(state, flush=True)

    def button(name: str | re.Pattern[str]) -> Locator:
        return page.get_by_role("button", name=name, exact=isinstance(name, str))

    def shut() -> None:
        """Fold the panel where it is a sheet over the map."""
        tab = page.locator("nav [aria-expanded=true]")
        if tab.count():
            tab.click()

    page.goto(address)
    page.get_by_text("Niemand fährt.").wait_for()
    shoot("no-driver", shut)
    shoot("places", lambda: show(page, "Ziel"))
    show(page, "Ziel")
    page.get_by_role("searchbox").fill("Station 4")
    page.get_by_role("searchbox").press("Enter")
    expect(button("Start")).to_have_attribute("aria-disabled", "false", timeout=60_000)
    shoot("overview")
    button("Start").click()
    page.wait_for_timeout(4000)
    shoot("under-way", shut)
    button("STOP").click()
    shoot("stopped", shut)
    shoot("mode", lambda: show_mode(page))
    show(page, "Einstellungen")
    page.get_by_label("Zwei Taster").check()
    shoot("switches", shut)
    button("Fahrt abbrechen").click()
    page.goto(f"{address}/therapist#token={token}")
    page.get_by_role("heading", name="Protokoll").wait_for()
    shoot("therapist")
    page.get_by_role("button", name="Alle löschen …").click()
    shoot("dialog")
    context.close()


def show_mode(page: Page) -> None:
    """Open the choice of who steers, unless it is open."""
    header = page.locator(".top [aria-controls=panel]")
    if header.get_attribute("aria-expanded") != "true":
        header.click()


def set_off(page: Page, place: str, overview: Path, seconds: float) -> None:
    """Look at a trip, keep its overview, start it, and ride for a while."""
    look_at(page, place)
    page.wait_for_timeout(700)
    keep(page, overview)
    page.get_by_role("button", name=START).click()
    page.get_by_role("button", name="OK").click()
    ride(page, seconds)
    # The first arcs about the chair are explained in the same place.
    note = page.get_by_role("group", name="What the arcs mean")
    if note.is_visible():
        note.get_by_role("button").click()


def go_on(page: Page, done: Callable[[], bool]) -> None:
    """Confirm whatever the page asks for, until something is the case."""
    button = page.get_by_role("button", name=GO_ON)
    for _ in range(400):
        if done():
            return
        if button.count() and button.get_attribute("aria-disabled") != "true":
            button.click()
        page.wait_for_timeout(300)
    raise TimeoutError("it did not happen")


def until_arrival(page: Page) -> None:
    """Go on to the destination."""
    go_on(page, page.get_by_text("You have arrived").first.is_visible)


def keep(shown: Page | Locator, path: Path) -> None:
    """Write a picture with a reduced palette."""
    picture = Image.open(io.BytesIO(shown.screenshot())).convert("RGB")
    picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path} is too large")


PARTS = {
    "connection": connection,
    "phones": phones,
    "desktops": desktops,
    "themes": themes,
    "sessions": sessions,
    "windows": windows,
}

if __name__ == "__main__":
    sys.exit(main())
