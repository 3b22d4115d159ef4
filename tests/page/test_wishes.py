"""Wishes about the route: what they cover, what is said of them, and when they end."""

import os
import re
import signal

import numpy as np
from playwright.sync_api import expect

from cohelm.geometry import distance_to_polygon, resample

from .test_trip_choices import ways


def wish_for(rider, place, name="Avoid"):
    rider.press("Go via, avoid, draw…")
    rider.page.get_by_label("Choose a place").select_option(place)
    rider.press(name)


def within(points, area):
    """Length of a route within an area, m."""
    close = resample(points, 0.1)
    return 0.1 * sum(distance_to_polygon(area, x, y) < 0.0 for x, y in close)


def test_a_place_to_avoid_is_all_of_it_and_of_this_trip_only(rider, chair):
    """The Cafeteria is reached by the south corridor alone; its last metres cannot be avoided."""
    area = next(each["area"] for each in chair.scene["places"] if each["name"] == "South corridor")
    rider.look_at("Cafeteria")
    wish_for(rider, "South corridor")
    wish = rider.page.get_by_role("listitem").filter(has_text="Avoid South corridor")
    told = re.compile(r"cannot be avoided: [\d.]+ m of the best route lead through it")
    expect(wish).to_contain_text(told, timeout=60_000)
    rider.until_button("Start")
    rider.press("Start")
    way = ways(chair, lambda way: way["wishes"] and way["extra_length"] > 5.0)
    assert [each["points"] for each in way["wishes"]] == [area]
    assert within(np.array(way["points"]), np.array(area)) < 6.0  # of 24

    rider.press("Change route")
    rider.sees("Avoid South corridor")
    rider.press("Keep present trip")
    rider.press("Cancel trip")
    ways(chair, lambda way: not way["wishes"])
    rider.look_at("Ward 2")
    expect(rider.button(re.compile("^Remove: "))).to_have_count(0)


def test_while_a_change_is_planned_the_trip_under_way_can_be_cancelled(rider, chair):
    rider.take()
    rider.follow("Ward 4")
    planner = chair.previews
    os.kill(planner, signal.SIGSTOP)  # as on a computer that is too slow for it
    try:
        rider.show("Go to")
        rider.press("Choose another destination")
        rider.press("Cafeteria")
        rider.sees("Until you change it, the trip to Ward 4 stays.")
        expect(rider.button("Change to this trip")).to_have_attribute("aria-disabled", "true")
        rider.press("Cancel trip")
        rider.until(lambda state: state["goal"] is None)
        rider.sees("To Cafeteria")
    finally:
        os.kill(planner, signal.SIGCONT)
    rider.until_button("Start")


def test_the_focus_survives_every_change_of_view(rider):
    """By keyboard: list, overview, its panel below, the overview again, a cancelled trip."""
    at = "document.activeElement.closest('main') && document.activeElement !== document.body"

    def press(name):
        rider.button(name).focus()
        rider.page.keyboard.press("Enter")
        rider.rest(0.5)
        assert rider.page.evaluate(at), name

    rider.look_at("Ward 4")
    assert rider.page.evaluate(at)
    press("Go via, avoid, draw…")
    press("Speed")
    press("Show trip")
    press("Start")
    rider.until(lambda state: state["goal"])
    press("Change route")
    press("Keep present trip")
    press("Cancel trip")
