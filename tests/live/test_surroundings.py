"""The direction ring tells what the scanners measure; remembered people are told apart."""

import math

import numpy as np

from cohelm.live.control.surroundings import DIRECTIONS, NOT_SEEN, free_distances, in_view
from cohelm.messages import Observation, Scan

SQUARE = ((0.5, 0.3), (-0.5, 0.3), (-0.5, -0.3), (0.5, -0.3))


def observed(ranges, *, beams_from=-math.pi, mount=(0.0, 0.0, 0.0), pose=(0.0, 0.0, 0.0)):
    step = 2.0 * math.pi / 360
    scan = Scan(
        time=0.0, mount=np.array(mount), angle_min=beams_from, angle_increment=step,
        range_max=10.0, ranges=np.asarray(ranges, dtype=float),
    )  # fmt: skip
    zero = np.zeros(3)
    return Observation(
        time=0.0, pose=np.array(pose), pose_time=0.0, twist=zero, twist_time=0.0, scans=(scan,)
    )


def test_in_a_round_room_the_outline_is_taken_off():
    """2 m all round: ahead 2 − 0.5, aside 2 − 0.3 m."""
    free = free_distances(observed(np.full(360, 2.0)), SQUARE)
    assert len(free) == DIRECTIONS
    assert abs(free[0] - 1.5) < 1e-6
    assert abs(free[DIRECTIONS // 4] - 1.7) < 1e-6
    assert abs(free[DIRECTIONS // 2] - 1.5) < 1e-6


def test_what_no_beam_looks_at_is_not_free():
    """90 beams from −45° cover the quarter ahead only; an open beam is free as far as is told."""
    free = free_distances(observed(np.full(90, np.inf), beams_from=-math.pi / 4), SQUARE)
    assert free[0] == 4.0
    assert free[DIRECTIONS // 2] == NOT_SEEN


def test_without_a_planar_scanner_there_is_no_ring():
    empty = observed([1.0]).__class__(
        time=0.0, pose=np.zeros(3), pose_time=0.0, twist=np.zeros(3), twist_time=0.0
    )
    assert free_distances(empty, SQUARE) == ()
    assert in_view(empty, np.array([[3.0, 0.0]])) == (True,)


def test_a_person_is_in_view_where_a_return_is_close_in_any_frame():
    """One return 3 m ahead of a chair at (1, 2) that faces +y lies at (1, 5)."""
    ranges = np.full(360, np.inf)
    ranges[180] = 3.0
    seen = observed(ranges, pose=(1.0, 2.0, math.pi / 2))
    assert in_view(seen, np.array([[1.0, 5.2], [4.0, 2.0]])) == (True, False)
