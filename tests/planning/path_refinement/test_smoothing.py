"""Smoothing straightens and rounds, and keeps the required clearance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import read_only
from cohelm.maps import signed_distance
from cohelm.maps.distance import DistanceField
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.path_refinement.shortening import LineGrid
from cohelm.planning.path_refinement.smoothing import LineLimits, Smoothing, curvature_of, smooth

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
    grid = LineGrid(packed.packed, clearance, RESOLUTION, needed)
    line = smooth(way, grid, LineLimits(wanted), smoothing or Smoothing())
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


def test_a_bend_sharper_than_asked_spreads():
    blocked = np.zeros((60, 60), dtype=bool)
    blocked[:40, 20:40] = True
    clearance = read_only(signed_distance(blocked, RESOLUTION))
    weights = Weights.of(np.where(clearance > 0.5, 1.0, np.inf).astype(np.float32))
    found = shortest_path(weights, (10, 8), (10, 52))
    way = np.ascontiguousarray((found.cells[:, ::-1] + 0.5) * RESOLUTION)

    def line(curvature):
        grid = LineGrid(weights.packed, clearance, RESOLUTION, 0.5)
        return smooth(way, grid, LineLimits(0.5, curvature=curvature), Smoothing(hold=1.0))

    # Let go, it lies taut along the contour at 0.5 m; that is interpolated between cells of 0.1 m,
    # a polygon and no circle, so it bends by more than 1 / 0.5 m here and there.
    assert curvature_of(line(1.0 / 0.5)).max() < 0.75 * curvature_of(line(np.inf)).max()
    assert turning(line(1.0 / 0.5)) <= turning(line(np.inf)) + 1e-9


def test_curvature_is_that_of_an_arc_however_its_points_lie():
    rng = np.random.default_rng(3)
    at = np.sort(rng.uniform(0.0, 2.0, 30))
    arc = 0.5 * np.stack([np.cos(at), np.sin(at)], axis=-1)
    assert curvature_of(arc)[1:-1] == pytest.approx(2.0, rel=2e-2)
    assert curvature_of(arc)[[0, -1]].tolist() == [0.0, 0.0]


def test_pins_are_passed_within_a_cell():
    clearance = read_only(signed_distance(np.zeros((60, 80), dtype=bool), RESOLUTION))
    weights = Weights.of(np.ones((60, 80), dtype=np.float32))
    there = shortest_path(weights, (10, 10), (40, 40)).cells
    back = shortest_path(weights, (40, 40), (10, 70)).cells[1:]
    way = (np.concatenate([there, back])[:, ::-1] + 0.5) * RESOLUTION
    waypoint = len(there) - 1

    def line(waypoints):
        grid = LineGrid(weights.packed, clearance, RESOLUTION, needed)
        return smooth(
            np.ascontiguousarray(way),
            grid,
            LineLimits(wanted),
            Smoothing(),
            np.array(waypoints, dtype=np.int64),
        )

    assert np.hypot(*(line([]) - way[waypoint]).T).min() > 2.0 * RESOLUTION
    assert np.hypot(*(line([waypoint]) - way[waypoint]).T).min() <= RESOLUTION


def test_a_zone_is_not_cut_through():
    # Nothing stands there, but the weights are closed: a line may not shorten its way across.
    free = np.zeros((60, 80), dtype=bool)
    clearance = read_only(signed_distance(free, RESOLUTION))
    closed = np.ones((60, 80), dtype=np.float32)
    closed[0:40, 39:41] = np.inf
    weights = Weights.of(closed)
    found = shortest_path(weights, (10, 10), (10, 70))
    way = np.ascontiguousarray((found.cells[:, ::-1] + 0.5) * RESOLUTION)
    grid = LineGrid(weights.packed, clearance, RESOLUTION, needed)
    line = smooth(way, grid, LineLimits(wanted), Smoothing())
    # No deeper than a quarter of a cell: what a chord of 0.1 m cuts off a corner.
    shifts = 0.25 * RESOLUTION * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    row, col = np.floor((line + shifts[:, None])[..., ::-1] / RESOLUTION).astype(int).T
    assert np.isfinite(closed[row, col]).any(axis=1).all()
