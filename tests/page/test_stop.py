"""STOP: from every state, by whatever hand, from whichever page; and what follows it."""

import re

import pytest
from playwright.sync_api import expect

from .rider import GO_ON
from .served import held, moves, stands, wants


def stopped(state):
    """On a busy machine a page may be silent for a moment, besides."""
    return held(state) and state["link"] != "ready"


def code(state):
    return state["reason"] and state["reason"]["code"]


BY = {
    "mouse": lambda rider: rider.press("STOP"),
    "Esc": lambda rider: rider.page.keyboard.press("Escape"),
    "Space": lambda rider: rider.page.keyboard.press("Space"),
}


@pytest.mark.parametrize("by", BY)
def test_while_the_stick_is_held(rider, by):
    """It is neither driven on nor resumed: let go first, then say to go on."""
    rider.take()
    rider.hold()
    BY[by](rider)
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")
    rider.sees("Stopped. Release the stick, then tap “Go on”.")
    rider.button("Go on").click(force=True)
    rider.holds(stopped)
    rider.let_go()
    rider.until(lambda state: state["link"] == "confirm")
    rider.page.keyboard.down("ArrowLeft")
    rider.holds(held)
    rider.let_go()
    rider.go_on()
    rider.hold()
    rider.let_go()


def test_while_it_follows_its_way(rider):
    rider.take()
    rider.follow()
    expect(rider.button(GO_ON)).to_have_count(0)  # nothing to press while it drives
    stop = rider.button("STOP").bounding_box()
    rider.press("STOP")
    rider.until(lambda state: stands(state) and state["link"] == "confirm")
    expect(rider.button("Go on to Ward 4")).to_have_class(re.compile("main"))
    assert rider.button("STOP").bounding_box() == stop
    place = rider.button("Go on to Ward 4").bounding_box()
    rider.press("Change route")
    expect(rider.button("Go on to Ward 4")).to_have_count(0)  # one button, in one place
    assert rider.button("Start this trip").bounding_box() == place
    rider.press("Keep present trip")
    rider.holds(held)
    rider.makes(wants, rider.go_on)


def test_while_nobody_drives(rider):
    """Who comes next has to say to go on."""
    rider.aim("Ward 4")
    rider.press("STOP")
    rider.press("Drive from this screen")
    rider.until(lambda state: rider.drives and state["link"] == "confirm")
    rider.holds(held)


@pytest.mark.parametrize(
    ("path", "told", "here"),
    [
        ("/", "STOP was pressed on another screen.", "STOP was pressed on another screen."),
        ("/therapist", "The therapist stopped the chair.", "The therapist stopped the chair."),
    ],
)
def test_from_a_page_that_does_not_drive_is_told_as_theirs(rider, riders, chair, path, told, here):
    rider.take()
    rider.follow()
    other = riders(path=f"{path}#token={chair.token}" if path != "/" else path)
    other.sees("Another screen drives" if path == "/" else "Driving to Ward 4")
    other.press("STOP")
    rider.until(stopped)
    assert rider.drives
    rider.sees(told)
    other.sees(here)
    rider.go_on()


def test_a_stick_that_is_held_back_says_that_the_chair_will_move_on(rider):
    """It is no STOP: nothing is to be pressed, and no sentence says so."""
    rider.take()
    rider.follow()
    rider.leave_fields()
    rider.makes(moves, lambda: None)
    rider.page.keyboard.down("ArrowDown")
    rider.until(lambda state: held(state) and code(state) == "stick_back")
    rider.sees("You hold the stick back. The chair moves on when you release it.")
    rider.sees("The trip to Ward 4 is on hold.")
    expect(rider.button(GO_ON)).to_have_count(0)
    rider.let_go("ArrowDown")
    rider.makes(wants, rider.go_on)


def test_a_stick_that_must_be_released_is_the_one_thing_to_do(rider, riders):
    """Taken over with the stick held and no trip: on its release the chair may be steered."""
    riders().take()
    rider.leave_fields()
    rider.sees("Another screen drives")
    rider.page.keyboard.down("ArrowLeft")
    rider.press("Drive from this screen")
    rider.until(lambda state: rider.drives and state["link"] == "centre_stick")
    rider.sees("Release the stick, then steer.")
    expect(rider.button(GO_ON)).to_have_count(0)
    rider.let_go()
    rider.until(lambda state: state["link"] == "ready")


def test_while_the_stick_must_be_let_go_first(rider, riders):
    """Taken over with the stick held: it does not count, and STOP is STOP all the same."""
    riders().take()
    rider.leave_fields()
    rider.sees("Another screen drives")
    rider.page.keyboard.down("ArrowLeft")
    rider.press("Drive from this screen")
    rider.until(lambda state: rider.drives)
    rider.press("STOP")
    rider.until(lambda state: stands(state) and code(state) == "rider_stop")
    rider.let_go()
    rider.until(lambda state: state["link"] == "confirm")


def test_while_it_waits_to_be_told_to_go_on(rider):
    rider.take()
    for _ in range(2):
        rider.press("STOP")
        rider.until(lambda state: state["link"] == "confirm")
        rider.holds(stopped, 0.3)


def test_while_time_stands_still(rider):
    """Going on with time moves nothing."""
    rider.take()
    rider.follow()
    rider.show("Simulation")
    rider.press("Pause")
    rider.until(lambda state: state["paused"])
    rider.press("STOP")
    rider.press("Resume")
    rider.until(lambda state: not state["paused"])
    rider.holds(stopped)


def test_while_the_simulation_begins_anew(rider, chair):
    rider.take()
    rider.show("Simulation")
    rider.press("Restart")
    rider.press("STOP")
    chair.heard(lambda told: told.get("code") == "simulation_restarted")
    rider.until(lambda state: state["link"] == "confirm")


def test_while_the_link_is_lost(rider):
    """Nothing reaches the chair: it stands by itself, and the page says so."""
    rider.take()
    rider.hold()
    rider.cable.tear()
    rider.sees("Connection to the chair lost.")
    rider.press("STOP")
    rider.until(lambda state: stands(state) and state["driver"] is None)
    said = rider.page.get_by_role("alert").filter(has_text="The chair stops by itself.")
    assert said.count() > 0
    rider.let_go()
    rider.cable.mend()
    rider.sees("No driver.")
