"""A view that breaks off, and fewer beams on mapped walls since: together they are a carry."""

import math

import numpy as np
import pytest

from cohelm.health import HealthParameters
from cohelm.health.map_fit import MapFit
from cohelm.health.sweeps import Continuity, update_continuity

P = HealthParameters()
PERIOD = 0.1


def fit(hit, short):
    """Fit of a sweep of which some beams end on walls and others before them."""
    none = np.zeros(0)
    return MapFit(none.astype(np.int64), none, hit, short, 0, 0, np.zeros(3), 0.0)


def after(sweeps, before=None, start=0.0):
    """Continuity after sweeps of (inliers, beams on walls, beams before them)."""
    state = before or Continuity()
    for i, (inliers, hit, short) in enumerate(sweeps):
        state = update_continuity(state, inliers, fit(hit, short), PERIOD, start + PERIOD * i, P)
    return state


SOUND = after([(0.9, 100, 10)] * 20)


def test_the_usual_shares_are_those_of_a_steady_drive():
    assert SOUND.inliers == pytest.approx(0.9)
    assert SOUND.on_walls == pytest.approx(100 / 110)
    assert SOUND.fall == 0.0


@pytest.mark.parametrize("broken", [1, 5])
def test_a_break_after_which_less_is_on_walls_tells_for_as_long_as_that_lasts(broken):
    """Also when the sweeps continue each other again, for they all show the new place."""
    sweeps = [(0.4, 80, 30)] * broken + [(0.9, 80, 30)] * 60
    state = after(sweeps, SOUND, 2.0)
    assert state.fall == pytest.approx(20 / 110)
    back = after([(0.9, 100, 10)] * 12, state, 2.0 + PERIOD * len(sweeps))
    assert back.fall == 0.0


def test_one_of_both_alone_tells_nothing():
    hidden = after([(0.9, 40, 70)] * 30, SOUND, 2.0)  # people come between chair and walls
    assert hidden.fall == 0.0
    broken = after([(0.4, 100, 10)] * 30, SOUND, 2.0)  # another view of the same walls
    assert broken.fall < P.break_fall


def test_a_fall_long_after_a_break_is_not_due_to_it():
    calm = after([(0.4, 100, 10), *[(0.9, 100, 10)] * 15], SOUND, 2.0)
    assert after([(0.9, 40, 70)] * 5, calm, 4.0).fall == 0.0


def test_a_slow_loss_of_what_continues_is_no_break():
    """A crowd that gathers: 2 % of the points in each sweep, for which the usual share makes up."""
    slow = after([(0.9 - 0.02 * i, 100 - 3 * i, 10 + 3 * i) for i in range(25)], SOUND, 2.0)
    assert slow.fall == 0.0


def test_sweeps_that_cannot_be_compared_or_show_hardly_any_wall_tell_nothing():
    unknown = after([(math.nan, 50, 60)] * 10, SOUND, 2.0)
    assert unknown.fall == 0.0
    few = after([(0.4, 2, 20)] * 10, after([(0.9, 20, 2)] * 20), 2.0)
    assert few.fall == 0.0
