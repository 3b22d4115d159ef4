"""Driving by keys, mouse, touch, a gamepad and a switch: each reaches the wheels, and stops."""

import json
import time

import pytest

from .rider import GO_ON
from .served import held, stands, wants

KEYS = {
    "ArrowLeft": lambda state: state["command"][1] > 0.1,
    "KeyD": lambda state: state["command"][1] < -0.1,
    "ArrowUp": lambda state: state["command"][0] > 0.05,
    "KeyS": lambda state: state["command"][0] < -0.05,
}


def turns_left(state):
    return state["command"][1] > 0.1


def turns_right(state):
    return state["command"][1] < -0.1


def test_keys(rider):
    rider.take()
    for key, law in KEYS.items():
        state = rider.hold(key, law)
        assert state["device"] == "keys"
        rider.let_go(key)
        rider.until(stands)
        rider.go_on()


def middle(box):
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_the_stick_by_mouse(rider):
    rider.take()
    x, y = middle(rider.page.get_by_test_id("joystick").bounding_box())
    mouse = rider.page.mouse

    def drag():
        mouse.move(x, y)
        mouse.down()
        mouse.move(x - 50, y)

    assert rider.makes(turns_left, drag, mouse.up)["device"] == "joystick"
    mouse.up()
    rider.until(stands)


class Fingers:
    """On a touch screen; each at a place, (x, y) px."""

    def __init__(self, rider):
        self._send = rider.context.new_cdp_session(rider.page).send

    def be(self, kind, *at):
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(at)]
        self._send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})


PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


def test_touch_drives_and_a_second_finger_stops(riders):
    """STOP while the first finger holds the stick; it does not count until it was let go."""
    rider = riders(**PHONE)
    fingers = Fingers(rider)
    rider.sees("No driver.")
    rider.take()
    x, y = middle(rider.page.get_by_test_id("joystick").bounding_box())
    stop = middle(rider.button("STOP").bounding_box())

    def drag():
        fingers.be("Start", (x, y))
        fingers.be("Move", (x + 40, y))

    assert rider.makes(turns_right, drag, lambda: fingers.be("End"))["device"] == "joystick"
    fingers.be("Start", (x + 40, y), stop)
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")
    fingers.be("End", (x + 40, y))
    rider.holds(lambda state: stands(state) and state["link"] != "ready")
    fingers.be("End")
    rider.until(lambda state: state["link"] == "confirm")


def test_a_gamepad_counts_from_its_centre_on(rider):
    pad = lambda *at: rider.page.evaluate("at => pad(...at)", list(at))  # noqa: E731 # short
    rider.take()
    pad(0, 0.8)
    rider.sees("Release the gamepad first.")
    rider.holds(held)
    pad(0, 0)
    rider.rest(0.1)
    state = rider.makes(turns_left, lambda: pad(0, 0.8), lambda: (pad(0, 0), rider.rest(0.1)))
    assert state["device"] == "gamepad"
    pad(0, 0.8, [1])
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")
    pad(0, 0)
    rider.until(lambda state: state["link"] == "confirm")
    rider.until_button(GO_ON)
    pad(0, 0, [9])
    rider.until(lambda state: state["link"] == "ready")


def test_a_gamepad_that_repeats_its_last_state_stops_the_chair_and_is_named(rider):
    """As after a lost link: connected, and without any change; the keys take over."""
    pad = lambda *at: rider.page.evaluate("at => pad(...at)", list(at))  # noqa: E731 # short
    rider.take()
    pad(0, 0)
    rider.rest(0.1)
    rider.makes(turns_left, lambda: pad(0, 0.8), lambda: (pad(0, 0), rider.rest(0.1)))
    rider.sees("The gamepad has not changed for too long")
    state = rider.until(stands)
    assert state["device"] == "none"
    rider.hold()
    rider.let_go()
    rider.until(stands)
    pad(0, 0)
    rider.rest(0.1)
    rider.makes(turns_left, lambda: pad(0, 0.7), lambda: (pad(0, 0), rider.rest(0.1)))


@pytest.mark.parametrize("latched", [[5], [0], [5, 0, 2]])
def test_a_latched_button_of_a_gamepad_leaves_stop_to_the_others(rider, latched):
    pad = lambda *at: rider.page.evaluate("at => pad(...at)", list(at))  # noqa: E731 # short
    pad(0, 0, latched)
    rider.rest(0.1)
    rider.take()
    rider.makes(turns_left, lambda: pad(0, 0.8, latched), lambda: pad(0, 0, latched))
    pad(0, 0.8, [*latched, 1])
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")


def test_a_latched_mouse_button_leaves_stop_to_the_main_one(rider):
    rider.take()
    rider.hold()
    mouse = rider.page.mouse
    mouse.move(*middle(rider.button("STOP").bounding_box()))
    mouse.down(button="middle")
    mouse.down()  # and it stays down
    rider.until(lambda state: stands(state) and state["link"] == "stick_held")
    mouse.up()
    mouse.up(button="middle")
    rider.let_go()


def test_an_idle_gamepad_never_overrides_keys(rider):
    rider.take()
    rider.page.evaluate("pad(0, 0)")
    rider.hold()
    for at in (0.02, -0.03, 0.0):
        rider.page.evaluate("at => pad(0, at)", at)
        rider.rest(0.1)
    assert rider.chair.state["device"] == "keys"
    rider.page.evaluate("pad(0, -0.9)")
    rider.rest(0.3)
    assert not turns_right(rider.chair.state)
    rider.let_go()


BUSY_PAGE = """() => {
  const busy = (since) => { while (performance.now() - since < 600); };
  setTimeout(() => busy(performance.now()));
}"""
BOUNCE = """([edge, back]) => {
  const began = performance.now();
  const say = (name) => document.body.dispatchEvent(
    new KeyboardEvent(name, { code: "Space", bubbles: true, cancelable: true }));
  say(edge);
  for (const time of [15, 40, 60]) {
    while (performance.now() - began < time);
    say(back);
    say(edge);
  }
}"""
SWITCH = f"localStorage.setItem('cohelm.switches', '{json.dumps({'count': 1})}')"


@pytest.fixture
def switch(riders):
    rider = riders(before=SWITCH)
    rider.sees("No driver.")
    words = rider.page.get_by_test_id("scan")

    def lights(lit):
        """Wait until this is lit."""
        for _ in range(600):
            if words.inner_text().startswith(lit):
                break
            rider.rest(0.04)
        else:
            raise AssertionError(f"{lit} is not lit, but {words.inner_text()}")

    def press(lit):
        lights(lit)
        rider.page.keyboard.press("Space")
        rider.rest(0.15)  # the next press is no bounce

    rider.leave_fields()
    rider.press_switch, rider.lights = press, lights
    return rider


def test_one_switch_takes_the_stick_turns_and_stands(switch):
    """Everything with one key: to begin, to choose what is lit, and to stand."""
    switch.press_switch("Press to start")
    switch.press_switch("Drive from this screen")
    state = switch.until(lambda state: switch.drives and state["link"] in {"ready", "confirm"})
    if state["link"] == "confirm":
        switch.press_switch("Go on")
    state = switch.makes(turns_left, lambda: switch.press_switch("Left"))
    assert state["device"] == "switch"
    switch.press_switch("Driving left")
    switch.until(stands)
    assert switch.chair.state["link"] == "ready"


def test_a_switch_that_bounces_drives_on_until_it_is_pressed_again(switch):
    bounce = lambda *edges: switch.page.evaluate(BOUNCE, edges)  # noqa: E731 # short
    switch.take()
    switch.leave_fields()
    switch.press_switch("Press to start")

    def press():
        switch.lights("Left")
        bounce("keydown", "keyup")
        switch.rest(0.3)
        bounce("keyup", "keydown")

    switch.makes(turns_left, press)
    switch.holds(turns_left, 0.5)
    switch.page.keyboard.press("Space")
    switch.until(stands)


def test_one_press_of_the_switch_stops_a_chair_that_follows_its_way(switch):
    switch.take()
    switch.follow()
    switch.leave_fields()
    switch.press_switch("Press to STOP")
    state = switch.until(lambda state: stands(state) and state["link"] == "confirm")
    assert state["reason"]["code"] == "rider_stop"
    switch.makes(wants, lambda: switch.press_switch("Go on"))


def test_a_press_that_a_busy_page_handled_late_counts(rider):
    """A key overtakes the beats that a busy page could not send, and the chair hears the page."""
    rider.take()
    rider.follow()
    rider.page.keyboard.press("Escape")
    rider.until(lambda state: stands(state) and state["link"] == "confirm")
    rider.until_button(GO_ON)
    rider.button(GO_ON).focus()
    since = rider.chair.state["clock"]
    rider.page.evaluate(BUSY_PAGE)
    time.sleep(0.1)  # it is busy when the key comes
    rider.page.keyboard.press("Enter")
    rider.until(wants)
    links = [each["link"] for each in [*rider.chair.states] if each["clock"] > since]
    assert "no_heartbeat" in links
