"""Returns of the robot itself."""

import numpy as np
import pytest

from cohelm.messages import Scan
from cohelm.perception.preprocessing.own_returns import NEAREST, without_own_returns

SQUARE = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])


def scan(ranges, x=0.0, turn=0.0):
    return Scan(
        time=0.0,
        mount=np.array([x, 0.0, turn]),
        angle_min=0.0,
        angle_increment=np.pi / 2.0,
        range_max=10.0,
        ranges=np.array(ranges),
    )


def test_returns_within_the_outline_are_dropped_and_no_others():
    seen = without_own_returns(scan([0.4, 0.6, 0.4, np.inf]), SQUARE).ranges
    assert np.isnan(seen).tolist() == [True, False, True, False]


def test_the_outline_is_that_of_the_robot_not_of_the_sensor():
    # From x = 0.3 the front ends after 0.2 m, the back after 0.8 m.
    assert np.isnan(without_own_returns(scan([0.3, 9, 0.7, 9], x=0.3), SQUARE).ranges).tolist() == [
        False, False, True, False,
    ]  # fmt: skip


def test_without_an_outline_only_what_touches_the_sensor_is_its_own():
    seen = without_own_returns(scan([0.9 * NEAREST, 1.1 * NEAREST, 1.0, np.nan]), None).ranges
    assert np.isnan(seen).tolist() == [True, False, False, True]


@pytest.mark.parametrize("outline", [None, SQUARE])
def test_a_scan_without_own_returns_stays_as_it_is(outline):
    given = scan([2.0, 3.0, np.inf, np.nan])
    assert without_own_returns(given, outline) is given
