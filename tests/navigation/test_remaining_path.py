"""The remaining part of path and wishes."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import Path, Wish, WishReport
from cohelm.navigation.replanning.remaining_path import (
    remaining_path,
    remaining_wishes,
    trim_strokes,
)


def straight(length=10.0):
    """Along x from 0, a point each 0.1 m."""
    points = np.column_stack(
        [np.linspace(0.0, length, round(10 * length) + 1), np.zeros(round(10 * length) + 1)]
    )
    return Path(
        points=points,
        length=length,
        cost=length,
        method="straight",
        wishes=WishReport(closest=[]),
        without_wishes=points,
    )


def straight_points(*xs, y=0.5):
    return np.array([[x, y] for x in xs])


@pytest.mark.parametrize("progress", [0.0, 3.14, 9.99, 10.0, 12.0])
def test_the_rest_of_a_path_begins_at_the_chair_and_ends_at_the_goal(progress):
    rest = remaining_path(straight(), progress)
    np.testing.assert_allclose(rest[0], [min(progress, 10.0), 0.0], atol=1e-12)
    np.testing.assert_allclose(rest[-1], [10.0, 0.0])
    assert len(rest) >= 2


def test_ordered_points_are_dropped_one_by_one():
    wish = Wish(points=straight_points(2.0, 5.0, 8.0))
    left = [remaining_wishes((wish,), straight(), at) for at in (0.0, 1.9, 2.1, 5.1, 8.1)]
    assert [[len(w.points) for w in each] for each in left] == [[3], [3], [2], [1], []]
    assert left[1][0] is wish
    np.testing.assert_array_equal(left[2][0].points, wish.points[1:])


def test_points_out_of_order_along_the_path_wait_for_the_one_before():
    """The second is passed at 2 m, but counts only once the first is, at 5 m."""
    wish = Wish(points=straight_points(5.0, 2.0))
    assert remaining_wishes((wish,), straight(), 3.0) == (wish,)
    assert remaining_wishes((wish,), straight(), 5.5) == ()


def test_a_zone_to_avoid_is_never_passed():
    zone = Wish(kind="avoid", points=straight_points(1.0), radius=0.5)
    assert remaining_wishes((zone,), straight(), 10.0) == (zone,)


def test_a_stroke_keeps_the_piece_under_way_and_is_cut_there_for_planning():
    stroke = Wish(kind="stroke", points=straight_points(1.0, 4.0, 8.0))
    assert remaining_wishes((stroke,), straight(), 0.5)[0] is stroke
    for at, first, cut in [(3.0, 1.0, 3.0), (5.0, 4.0, 5.0)]:
        (left,) = remaining_wishes((stroke,), straight(), at)
        assert left.points[0, 0] == first
        (planned,) = trim_strokes((left,), straight(), at)
        np.testing.assert_allclose(planned.points[0], [cut, 0.5])
        np.testing.assert_array_equal(planned.points[-1], stroke.points[-1])
    assert remaining_wishes((stroke,), straight(), 8.5) == ()
    assert trim_strokes((stroke,), straight(), 0.5)[0] is stroke


def test_dropping_twice_is_dropping_once():
    wishes = (
        Wish(points=straight_points(2.0, 5.0)),
        Wish(kind="stroke", points=straight_points(1.0, 4.0, 8.0)),
    )
    once = remaining_wishes(wishes, straight(), 4.5)
    assert remaining_wishes(once, straight(), 4.5) == once
    later = remaining_wishes(once, replace(straight()), 8.5)
    assert later == ()
