import numpy as np
import pytest

from cohelm.geometry import compose
from cohelm.messages import Scan
from cohelm.perception import scan_returns


def scan(ranges, **changes):
    given = {
        "time": 0.0,
        "mount": np.zeros(3),
        "angle_min": 0.0,
        "angle_increment": np.pi / 2,
        "range_max": 10.0,
        "ranges": np.array(ranges, dtype=float),
    }
    return Scan(**{**given, **changes})


def test_beams_end_where_frames_compose():
    X_MR, X_RS = np.array([1.0, 2.0, 0.5]), np.array([0.3, -0.1, 1.0])
    seen = scan_returns(scan([2.0, 3.0], mount=X_RS), X_MR)
    X_MS = compose(X_MR, X_RS)
    # the second beam looks to the sensor's left: (0, 3) in its frame
    expected = [compose(X_MS, [2.0, 0.0, 0.0])[:2], compose(X_MS, [0.0, 3.0, 0.0])[:2]]
    assert seen.points == pytest.approx(np.array(expected))
    assert seen.origin == pytest.approx(X_MS[:2])


def test_only_ranges_within_reach_are_returns_and_only_inf_is_free():
    seen = scan_returns(scan([np.nan, np.inf, -np.inf, 0.0, -1.0, 10.0, 10.1, 1.0]), np.zeros(3))
    assert seen.range.tolist() == [10.0, 1.0]
    # the one free beam looks left and is free as far as 10 m
    assert seen.free_ends == pytest.approx(np.array([[0.0, 10.0]]))


def test_a_clockwise_scanner_gives_the_same_points_in_the_same_order():
    ahead = scan([1.0, 2.0, 3.0], angle_increment=0.2)
    back = scan([3.0, 2.0, 1.0], angle_min=0.4, angle_increment=-0.2)
    a, b = scan_returns(ahead, np.zeros(3)), scan_returns(back, np.zeros(3))
    assert b.points == pytest.approx(a.points)
    assert b.bearing == pytest.approx(a.bearing)
    assert b.increment == a.increment


@pytest.mark.parametrize(
    ("changes", "pose"),
    [
        ({"range_max": np.nan}, np.zeros(3)),
        ({"range_max": np.inf}, np.zeros(3)),
        ({"angle_min": np.nan}, np.zeros(3)),
        ({"mount": np.array([np.nan, 0.0, 0.0])}, np.zeros(3)),
        ({}, np.array([0.0, np.inf, 0.0])),
        ({"ranges": np.empty(0)}, np.zeros(3)),
    ],
)
def test_what_is_not_finite_has_no_returns(changes, pose):
    seen = scan_returns(scan(**{"ranges": [1.0, np.inf], **changes}), pose)
    assert len(seen.points) == len(seen.free_ends) == 0
    assert np.isfinite(seen.origin).all()
