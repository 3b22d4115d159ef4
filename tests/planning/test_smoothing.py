"""Smoothing straightens and rounds, and never trades away clearance that it must keep."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import read_only
from cohelm.maps import signed_distance
from cohelm.maps.distance import DistanceField
from cohelm.planning.search import Weights, shortest_path
from cohelm.planning.smoothing import Smoothing, smooth

RESOLUTION = 0.1
needed, wanted = 0.3, 0.6


def smoothed(blocked, start, goal, smoothing=None):
    """(line, clearance field, cells' centres) from start to goal, or None where there is no way."""
    clearance = read_only(signed_distance(blocked, RESOLUTION))
    weights = np.where(clearance > needed, 1.0 + 3.0 * np.exp(-3.0 * clearance), np.inf)
    packed = Weights.of(weights.astype(np.float32))
    found = shortest_path(packed, start, goal)
    if found is None:
        return None
    way = np.ascontiguousarray((found.cells[:, ::-1] + 0.5) * RESOLUTION)
    line = smooth(
        way,
        packed,
        clearance,
        RESOLUTION,
        needed=needed,
        wanted=wanted,
        smoothing=smoothing or Smoothing(),
    )
    return line, DistanceField(distance=clearance, resolution=RESOLUTION, X_MG=np.zeros(3)), way


def turning(points):
    """Summed change of direction, rad."""
    headings = np.unwrap(np.arctan2(*np.diff(points, axis=0).T[::-1]))
    return np.abs(np.diff(headings)).sum()


def test_equal_costs_end_in_a_straight_line():
    line, _, way = smoothed(np.zeros((50, 70), dtype=bool), (3, 4), (40, 60))
    assert np.allclose(np.diff(line, axis=0), np.diff(line, axis=0)[0], atol=1e-6)
    assert turning(line) < 1e-6 < turning(way)


def test_a_corner_is_rounded():
    blocked = np.zeros((60, 60), dtype=bool)
    blocked[:40, 20:40] = True  # a U round a box
    line, _, _ = smoothed(blocked, (10, 8), (10, 52))
    sharp, _, _ = smoothed(blocked, (10, 8), (10, 52), Smoothing(iterations=0))
    step = np.diff(line, axis=0)
    headings = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    assert turning(line) == pytest.approx(abs(headings[-1] - headings[0]), rel=0.05)  # no wiggle
    corner = np.diff(sharp, axis=0)
    sharpest = np.abs(np.diff(np.unwrap(np.arctan2(corner[:, 1], corner[:, 0])))).max()
    assert np.abs(np.diff(headings)).max() < 0.5 * sharpest


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_clearance_is_kept(seed):
    rng = np.random.default_rng(seed)
    blocked = rng.random((50, 60)) < 0.008
    blocked[5:9, 5:9] = blocked[40:45, 50:55] = False
    result = smoothed(blocked, (6, 6), (42, 52))
    if result is None:
        return
    line, field, way = result
    assert np.array_equal(line[[0, -1]], way[[0, -1]])
    assert field.at(line).min() >= min(needed, field.at(way[[0, -1]]).min()) - 2e-3
    assert np.hypot(*np.diff(line, axis=0).T).sum() <= np.hypot(*np.diff(way, axis=0).T).sum()
    assert np.hypot(*np.diff(line, axis=0).T).max() <= Smoothing().spacing + 1e-9
