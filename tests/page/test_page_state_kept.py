"""What stays: a trip until it is cancelled, buttons where they are, panels at their top."""

import os
import re
import signal

import pytest
from playwright.sync_api import expect

from .test_link import HIDE, SHOW

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True}
LONG = "The door to Treatment room 12 is shut. Please steer, or choose another destination."


def via_laboratory(rider):
    rider.look_at("Ward 4")
    rider.press("Go via, avoid, draw…")
    rider.page.get_by_label("Choose a place").select_option("Laboratory")
    rider.press("Go via here")
    rider.sees(re.compile(r"By way of Laboratory: \+[\d.]+ m\."))


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_a_trip_is_kept_until_the_rider_cancels_it(riders, size):
    rider = riders(viewport={"width": size[0], "height": size[1]})
    rider.sees("No driver.")
    via_laboratory(rider)
    panel = rider.page.get_by_role("region", name="Your trip")
    route = re.compile(r"about \d+ (s|min).* m")
    chosen = rider.page.get_by_role("button", name=route, pressed=True)
    expect(chosen).to_be_in_viewport(ratio=1.0)
    rider.show("Speed")
    expect(panel).to_contain_text("To Ward 4")
    expect(panel).to_contain_text("Go via Laboratory")
    rider.show("Settings")
    rider.show("Go to")
    rider.sees("Go via Laboratory")
    rider.press("Cancel trip")
    expect(panel).to_have_count(0)
    rider.sees(re.compile("^Destination$"))  # where the trip was chosen
    rider.look_at("Ward 4")
    expect(rider.page.get_by_text("Go via Laboratory")).to_have_count(0)


def test_a_place_on_the_way_is_asked_for_once(rider):
    rider.look_at("Ward 4")
    rider.press("Go via, avoid, draw…")
    expect(rider.page.get_by_text("Choose a place", exact=True)).to_have_count(1)


def test_a_panel_opens_at_its_top(riders):
    rider = riders(**PHONE)
    rider.sees("No driver.")
    rider.show("Settings")
    top = "document.querySelector('#panel').scrollTop"
    rider.page.evaluate(f"{top} = 200")
    assert rider.page.evaluate(top) > 100.0
    rider.show("Speed")
    assert rider.page.evaluate(top) == 0.0


def boxes(rider, *names):
    return [rider.button(name).bounding_box() for name in names]


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_no_button_moves_when_a_message_comes_or_goes(riders, size):
    rider = riders(viewport={"width": size[0], "height": size[1]})
    rider.sees("No driver.")
    fixed = ("STOP", "Go to", "Settings", "Drive from this screen")
    before = boxes(rider, *fixed)
    rider.page.evaluate("text => (document.querySelector('.stands').textContent = text)", LONG)
    rider.page.evaluate("text => (document.querySelector('.ready p').textContent = text)", LONG)
    assert boxes(rider, *fixed) == before
    rider.page.evaluate(HIDE)
    rider.sees(re.compile("This page is in the background"))
    assert boxes(rider, *fixed) == before
    rider.page.evaluate(SHOW)


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_the_overview_s_buttons_stand_still_while_routes_come(riders, chair, size):
    """The planner stands still until the buttons were looked at."""
    rider = riders(viewport={"width": size[0], "height": size[1]})
    rider.sees("No driver.")
    rider.show("Go to")
    os.kill(chair.previews, signal.SIGSTOP)
    try:
        rider.press("Cafeteria")
        rider.sees("Planning the route…")
        fixed = ("Start", "Go via, avoid, draw…", "Cancel trip")
        before = boxes(rider, *fixed)
    finally:
        os.kill(chair.previews, signal.SIGCONT)
    rider.until_button("Start")
    assert boxes(rider, *fixed) == before


@pytest.mark.slow  # a process begins anew, and imports
def test_routes_are_planned_anew_once_the_planner_is_back(rider, chair):
    rider.show("Go to")
    os.kill(chair.previews, signal.SIGKILL)
    rider.until(lambda state: not state["can_plan"])
    rider.press("Cafeteria")
    rider.sees("Routes cannot be planned yet. They appear by themselves.")
    rider.until(lambda state: state["can_plan"], within=120.0)
    rider.until_button("Start")
