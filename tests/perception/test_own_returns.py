"""Returns of the robot itself."""

import numpy as np
import pytest

from cohelm.messages import Scan
from cohelm.perception.preprocessing.own_returns import (
    NEAREST,
    learn_own_returns,
    without_own_returns,
)

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


def driven(poses, ranges_at):
    """Scans of a scanner at poses (k, 3) after own returns are learned."""
    known, out = (), []
    for k, pose in enumerate(poses):
        seen, known = learn_own_returns(scan(ranges_at(k)), np.array(pose), known)
        out.append(seen.ranges)
    return np.array(out)


def test_what_keeps_its_place_while_the_robot_drives_and_turns_is_its_own():
    poses = [(0.1 * k, 0.0, 0.1 * k) for k in range(12)]
    seen = driven(poses, lambda _: [0.4, 3.0, np.nan, 0.8])
    # Half a metre and half a radian later: from the sixth scan on.
    assert np.isnan(seen[:5, 0]).sum() == 0
    assert np.isnan(seen[6:, [0, 3]]).all()
    assert (seen[:, 1] == 3.0).all()


def test_a_wall_beside_a_straight_path_is_not_the_robots_own():
    seen = driven([(0.1 * k, 0.0, 0.0) for k in range(60)], lambda _: [0.4, 3.0, 3.0, 3.0])
    assert (seen[:, 0] == 0.4).all()


def test_who_walks_along_sways_and_is_not_the_robots_own():
    poses = [(0.1 * k, 0.0, 0.1 * k) for k in range(60)]
    seen = driven(poses, lambda k: [0.7 + 0.2 * np.sin(k), 3.0, 3.0, 3.0])
    assert np.isfinite(seen[:, 0]).all()


def test_own_parts_that_flicker_stay_own():
    poses = [(0.1 * k, 0.0, 0.1 * k) for k in range(30)]
    seen = driven(poses, lambda k: [0.4 if k < 10 or k % 2 else 2.0, 3.0, 3.0, 3.0])
    assert np.isnan(seen[11::2, 0]).all()
    assert (seen[10::2, 0] == 2.0).all()
