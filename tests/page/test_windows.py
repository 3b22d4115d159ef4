"""Every window: STOP and the one primary button in it, all the rest in reach; axe in all looks."""

import re

import pytest
from benchmarks.page import LONG_NAMES, LOOKS, WINDOWS
from playwright.sync_api import expect

from .served import brief, stands
from .test_access import AXE, LOOK, TAGS

ZOOMED = ((512, 300), (590, 410))
"""Tablets at 200 %, px."""
PINNED = """
() => {
  const shown = (each) => each.checkVisibility({ visibilityProperty: true });
  const at = (each) => {
    const { x, y, width, height } = each.getBoundingClientRect();
    const inside = Math.min(x, y, innerWidth - x - width, innerHeight - y - height) >= -0.5;
    const top = document.elementFromPoint(x + width / 2, y + height / 2);
    return [inside, each.contains(top), Math.min(width, height) >= 43.5];
  };
  const others = [...document.querySelectorAll("button.main:not(.ready *)")].filter(shown);
  const pinned = document.querySelectorAll("button[data-stop], .ready button");
  return [[...pinned].filter(shown).map(at), others.map((each) => each.textContent.trim())];
}
"""
LOST = """
() => {
  const parts = ":is(.top, .tabs, .panel, .under, .stick)";
  const which = `${parts} :is(button, input, select, a[href], [role=img])`;
  const shown = [...document.querySelectorAll(which)].filter((each) => each.checkVisibility());
  const lost = shown.filter((each) => {
    const part = each.closest("label") ?? each;
    part.scrollIntoView({ block: "nearest" });
    const { x, y, width, height } = part.getBoundingClientRect();
    const top = document.elementFromPoint(x + width / 2, y + height / 2);
    return !part.contains(top) || x < -0.5 || x + width > innerWidth + 0.5;
  });
  document.querySelector(".page").scrollTo(0, 0);
  return lost.map((each) => each.outerHTML.slice(0, 90));
}
"""
FITS = "document.documentElement.scrollWidth <= innerWidth"


def resize(page, window):
    page.set_viewport_size({"width": window[0], "height": window[1]})
    page.wait_for_timeout(150)


def look(rider, primary, state):
    """The laws of one state, in every window; a late chair may turn the button grey meanwhile."""
    expect(rider.button(primary)).to_have_class(re.compile("main"))
    page = rider.page
    for window in (*WINDOWS, *ZOOMED):
        resize(page, window)
        found = page.evaluate(PINNED)
        assert found == [[[True] * 3] * 2, []], (state, window, brief(rider.chair.state))
        assert page.evaluate(LOST) == [], (state, window)
        assert page.evaluate(FITS), (state, window)


@pytest.mark.parametrize("language", ["en-US", "de-DE"])
def test_stop_and_the_primary_button_are_in_every_window(riders, language):
    """One primary button a state, always in the same place."""
    rider = riders(before=LONG_NAMES, locale=language)
    page, german = rider.page, language == "de-DE"
    rider.sees("Niemand fährt." if german else "No driver.")
    look(rider, "Mit diesem Bildschirm fahren" if german else "Drive from this screen", "no driver")
    rider.show("Ziel" if german else "Go to")
    field = page.get_by_role("searchbox")
    field.fill("station 4")
    field.press("Enter")
    rider.until_button("Start")
    look(rider, "Start", "overview")
    rider.press("Start")
    rider.until(lambda state: rider.drives and state["goal"])
    rider.press("STOP")
    rider.until(lambda state: stands(state) and state["link"] == "confirm")
    place = "Neurologische Frührehabilitation, Station 4"
    look(rider, f"Weiter: {place}" if german else f"Go on to {place}", "stopped")
    page.locator(".top [aria-controls=panel]").click()
    look(rider, f"Weiter: {place}" if german else f"Go on to {place}", "who steers")


def test_the_therapist_s_stop_is_in_every_window(riders, chair):
    """Scrolled to its end, too."""
    rider = riders(path=f"/therapist#token={chair.token}")
    rider.page.get_by_role("heading", name="Audit log").wait_for()
    for window in (*WINDOWS, *ZOOMED):
        resize(rider.page, window)
        rider.page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        assert rider.page.evaluate(PINNED)[0] == [[True] * 3], window
        assert rider.page.evaluate(FITS), window


def test_axe_finds_nothing_in_any_window_and_look(riders):
    if not AXE.is_file():
        pytest.skip("needs axe-core: npm ci in page/")
    rider = riders(before=LONG_NAMES, bypass_csp=True)
    rider.sees("No driver.")
    rider.look_at("Station 4")
    rider.page.evaluate(AXE.read_text())
    for window in WINDOWS:
        resize(rider.page, window)
        for name, media in LOOKS.items():
            rider.page.emulate_media(**media)
            rider.rest(0.1)
            assert rider.page.evaluate(LOOK, TAGS) == [], (window, name)


def test_the_stick_has_its_knob_and_arrows_in_forced_colours(riders):
    """They are drawn by grounds, which forced colours take away unless they are kept."""
    rider = riders(forced_colors="active")
    rider.sees("No driver.")
    stick = rider.page.get_by_test_id("joystick")
    ground = "each => getComputedStyle(each).backgroundColor"
    behind = stick.evaluate(ground)
    parts = stick.locator(".knob, .arrow")
    expect(parts).to_have_count(5)
    assert all(each.evaluate(ground) != behind for each in parts.all())
