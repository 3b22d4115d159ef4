"""The least ellipse about points."""

import numpy as np
import pytest

from cohelm.perception.clustering.ellipses import bounding_ellipses

ONE = np.zeros(1, dtype=np.int64)


def test_points_on_an_ellipse_give_that_ellipse():
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    points = np.stack([0.8 * np.cos(t), 0.3 * np.sin(t)], axis=-1) @ turn.T + [5.0, -2.0]
    got = bounding_ellipses(points, np.zeros(60, dtype=np.int64), 1, 0.02)[0]
    assert got == pytest.approx([5.0, -2.0, 0.8, 0.3, 0.4], abs=0.01)


def test_a_square_gives_the_circle_through_its_corners():
    # the least ellipse about a square of side 2 is the circle of radius √2
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    got = bounding_ellipses(corners, np.zeros(4, dtype=np.int64), 1, 0.02)[0]
    assert got[2:4] == pytest.approx([np.sqrt(2.0)] * 2, rel=1e-3)


def test_every_point_lies_within_and_each_cluster_has_its_own():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(200, 2)) * [0.5, 0.1]
    labels = rng.integers(-1, 3, 200)
    for k, (x, y, a, b, way) in enumerate(bounding_ellipses(points, labels, 3, 0.02)):
        d = points[labels == k] - (x, y)
        along = d @ [np.cos(way), np.sin(way)]
        across = d @ [-np.sin(way), np.cos(way)]
        reach = (along / a) ** 2 + (across / b) ** 2
        assert reach.max() == pytest.approx(1.0, abs=2e-3)


def test_one_point_and_points_in_line_have_the_thinnest():
    one = bounding_ellipses(np.array([[1.0, 2.0]]), ONE, 1, 0.05)[0]
    assert one[:4] == pytest.approx([1.0, 2.0, 0.05, 0.05])
    line = np.column_stack([np.linspace(-1.0, 1.0, 9), np.zeros(9)])
    got = bounding_ellipses(line, np.zeros(9, dtype=np.int64), 1, 0.05)[0]
    assert got[2:4] == pytest.approx([1.0, 0.05], abs=0.01)
    assert len(bounding_ellipses(np.empty((0, 2)), np.empty(0, dtype=np.int64), 0, 0.05)) == 0
