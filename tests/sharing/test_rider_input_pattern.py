"""The hand on the stick, recognised by what it sends."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.sharing.hand import COARSE, FREE_STICK, update_hand

STEP = 0.05
EIGHTH = math.pi / 4.0


def sent(sticks, *, kind=None, time_constant=0.25):
    state, smoothed = FREE_STICK, np.zeros(2)
    for stick in sticks:
        raw = np.asarray(stick, dtype=float)
        share = 1.0 - math.exp(-STEP / time_constant)
        smoothed = smoothed + share * (raw - smoothed) if raw.any() else np.zeros(2)
        state = update_hand(raw, smoothed, STEP, state, given=kind)
    return state


def presses(*directions, size=0.5, ticks=8):
    """Deflections of a device that holds each direction, in eighths of a turn; None: released."""
    for each in directions:
        angle = 0.0 if each is None else each * EIGHTH
        length = 0.0 if each is None else size
        yield from [(length * math.cos(angle), length * math.sin(angle))] * ticks


def test_directions_of_a_grid_are_recognised():
    assert sent(presses(0, None, 2, None, 0)).kind == "one_switch"
    assert sent(presses(0, 1, 0, 7)).kind == "eight_directions"
    assert sent(presses(0, 1)).width == pytest.approx(math.pi / 8)
    assert sent(presses(0, None, 6)).width == pytest.approx(math.pi / 4)


def test_one_direction_that_is_held_exactly_is_a_switch():
    assert sent(presses(0, ticks=5)).kind == "stick"
    assert sent(presses(0, ticks=15)).kind == "one_switch"


def test_a_stick_that_leaves_the_grid_is_free_at_once():
    switched = list(presses(0, None, 2, None, 0))
    assert sent([*switched, (0.5, 0.1)]).kind == "stick"
    assert sent([*switched, (0.6, 0.0)]).kind == "stick"  # not deflected alike


def test_a_known_hand_is_not_guessed():
    assert sent([(0.7, 0.2)], kind="one_switch").width == pytest.approx(math.pi / 4)
    assert sent(presses(0, None, 2, None, 0), kind="stick").kind == "stick"


def test_a_tremor_widens_the_direction_and_a_steady_stick_does_not():
    times = np.arange(0.0, 6.0, STEP)
    steady = sent([(0.7, 0.1 + 1e-4 * t) for t in times])
    assert steady.width < 0.02
    # ±0.2 of 0.7 at 5 Hz, which the low-pass does not follow: rms 0.2 / √2 / 0.7 = 0.2 rad
    shaky = sent([(0.7, 0.2 * math.sin(2 * math.pi * 5.0 * t + 0.4)) for t in times])
    assert shaky.unsteadiness == pytest.approx(0.2, rel=0.2)
    assert shaky.width == pytest.approx(min(2 * shaky.unsteadiness, COARSE))


@given(st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=40))
def test_the_width_is_bounded_and_the_mirrored_hand_is_as_wide(sticks):
    one, other = sent(sticks), sent([(ahead, -left) for ahead, left in sticks])
    assert 0.0 <= one.width <= math.pi / 4
    assert one.width == pytest.approx(other.width, abs=1e-9)
    assert one.kind == other.kind
