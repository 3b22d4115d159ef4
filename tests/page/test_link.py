"""Whatever becomes of a page, its network or the navigator: the wheels stand within 400 ms."""

import os
import re
import signal
import time

import pytest
from playwright.sync_api import expect

from .rider import GO_ON
from .served import held, moves, stands, wants

HANG = (
    "setTimeout(() => { const end = performance.now() + 1500; while (performance.now() < end); })"
)
HIDE = """
Object.defineProperty(document, "visibilityState", { get: () => "hidden", configurable: true });
document.dispatchEvent(new Event("visibilitychange"));
"""
SHOW = "delete document.visibilityState; document.dispatchEvent(new Event('visibilitychange'))"


def under_way(rider, how):
    """By its stick, or by itself."""
    rider.take()
    if how == "by hand":
        rider.hold()
    else:
        rider.follow()
        rider.leave_fields()
    rider.makes(moves, lambda: None)
    return rider


WAYS = ("by hand", "by itself")


@pytest.mark.parametrize("how", WAYS)
def test_a_link_that_is_cut_without_a_word(riders, timely, how):
    """Measured from the last beat that the chair has heard of to the wheels."""

    def story():
        rider = under_way(riders(), how)
        began = time.monotonic()
        rider.cable.cut()
        rider.sees("The chair does not respond. It stops by itself.")
        return silent_for(rider, began)

    timely(story)


@pytest.mark.parametrize("how", WAYS)
def test_a_page_that_hangs(riders, timely, how):
    def story():
        rider = under_way(riders(), how)
        began = time.monotonic()
        rider.page.evaluate(HANG)
        time.sleep(1.0)
        return silent_for(rider, began)

    timely(story)


def silent_for(rider, since):
    """How long the wheels still turned after the last beat that reached the chair, s."""
    rider.until(lambda state: state["clock"] > since and held(state))
    stood = rider.chair.stood(since)
    told = rider.told_last(stood)
    rider.close()
    return stood - told


def away(rider, how):
    if how == "hidden":
        rider.page.evaluate(HIDE)
    elif how == "blurred":
        session = rider.context.new_cdp_session(rider.page)
        session.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
        rider.context.new_page().bring_to_front()
    elif how == "frozen":
        rider.signal(signal.SIGSTOP)
    elif how == "left":
        rider.page.goto("about:blank")
    elif how == "closed":
        rider.page.close()
    elif how == "crashed":
        rider.signal(signal.SIGKILL)


@pytest.mark.parametrize("how", ["hidden", "blurred", "frozen", "left", "closed", "crashed"])
def test_a_page_that_is_gone(riders, chair, timely, how):
    """Measured from the deed itself."""

    def story():
        rider = under_way(riders(), "by itself")
        began = time.monotonic()
        away(rider, how)
        chair.until(lambda state: state["clock"] > began and stands(state))
        found = chair.stood(began) - began
        chair.until(lambda state: state["link"] != "ready")
        rider.signal(signal.SIGCONT)
        rider.close()
        return found

    timely(story)


def test_a_page_that_was_hidden_is_asked_before_it_drives_on(rider):
    under_way(rider, "by hand")
    rider.page.evaluate(HIDE)
    rider.until(lambda state: stands(state) and state["link"] == "no_heartbeat")
    rider.page.evaluate(SHOW)
    rider.holds(held)
    rider.let_go()
    rider.until(lambda state: state["link"] == "confirm")
    rider.go_on()
    rider.hold()
    rider.let_go()


def test_a_navigator_that_is_killed(rider, chair):
    """The watchdog stands at the wheels, whatever the machine: its lateness alone is added."""
    under_way(rider, "by itself")
    began = time.monotonic()
    os.kill(chair.navigator, signal.SIGKILL)
    rider.until(stands)
    assert chair.stood(began) - began <= 0.4 + chair.lateness(began)
    rider.sees(re.compile("The navigator did not answer in time|This computer is too slow"))
    rider.sees("The navigator is starting again. You can go on in a moment.")
    expect(rider.button(GO_ON)).to_have_attribute("aria-disabled", "true")
    rider.until(lambda state: state["link"] == "confirm", within=120.0)
    chair.heard(lambda told: told.get("code") == "navigator_ready", within=240.0)
    assert chair.health()["restarts"] == 1
    rider.until_button(GO_ON)
    rider.holds(held)
    rider.makes(wants, rider.go_on)


def test_two_pages_and_a_take_over(rider, riders, chair):
    rider.take()
    rider.hold()
    other = riders()
    other.sees("Another screen drives")
    other.press("Drive from this screen")
    rider.sees("Another screen drives now.")
    other.sees("This screen drives now, and the other one no longer.")
    other.until(lambda state: other.drives)
    other.holds(held)  # the first one still holds its key
    rider.let_go()
    other.go_on()
    other.hold()
    other.let_go()
    assert chair.state["driver"] == other.client
