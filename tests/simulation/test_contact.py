"""Gaps of the footprint, against hand calculation and brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.geometry import distance_to_polygon, transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation.contact import gap_to_people, gap_to_walls

CHAIR = np.array([[0.6, 0.3], [-0.4, 0.3], [-0.4, -0.3], [0.6, -0.3]])


def test_people_ahead_beside_and_underneath():
    pose = np.array([1.0, 1.0, np.pi / 2])  # facing +y: reaches to y = 1.6, x = 0.7 … 1.3
    people = np.array([[1.0, 2.5], [2.0, 1.0], [1.0, 1.0], [1.7, 2.0]])
    gaps = gap_to_people(CHAIR, pose, people, np.full(4, 0.25))
    # 0.9 − r; 0.7 − r; −(0.3 + r); √(0.4² + 0.4²) − r
    np.testing.assert_allclose(gaps, [0.65, 0.45, -0.55, np.hypot(0.4, 0.4) - 0.25])


def test_a_wall_ahead_is_at_its_face():
    data = np.zeros((100, 120), dtype=np.int8)
    data[:, 80:] = 100  # from x = 4
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    for x, gap in ((1.0, 2.4), (3.0, 0.4), (3.39, 0.01)):
        assert gap_to_walls(CHAIR, np.array([x, 2.5, 0.0]), grid) == pytest.approx(gap)
    assert gap_to_walls(CHAIR, np.array([3.5, 2.5, 0.0]), grid) <= 0.0
    assert gap_to_walls(CHAIR, np.array([4.8, 2.5, 0.0]), grid) <= 0.0  # wholly inside


def test_unknown_is_no_wall_and_nothing_is_infinitely_far():
    grid = OccupancyGrid(data=np.full((9, 9), -1, np.int8), resolution=0.1, X_MG=np.zeros(3))
    assert gap_to_walls(CHAIR, np.zeros(3), grid) == np.inf


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_gap_to_cells_is_that_of_densely_sampled_borders(seed):
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((60, 60)) < 0.004, 100, 0).astype(np.int8)
    X_MG = np.array([*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)])
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=X_MG)
    pose = np.array([*transform(X_MG, rng.uniform(1, 5, 2)), rng.uniform(-3, 3)])
    polygon = transform(pose, CHAIR)
    along = np.linspace(-0.05, 0.05, 41)
    side = np.stack([along, np.full(41, 0.05)], axis=1)
    border = np.vstack([side, -side, side[:, ::-1], -side[:, ::-1]])
    cells = np.argwhere(grid.occupied())[:, ::-1] * 0.1 + 0.05
    points = transform(X_MG, (cells[:, None] + border).reshape(-1, 2))
    expected = min((distance_to_polygon(polygon, *p) for p in points), default=np.inf)
    gap = gap_to_walls(CHAIR, pose, grid)
    if expected > 0.0:
        assert gap == pytest.approx(expected, abs=2e-3)  # 2.5 mm between samples
    else:
        assert gap <= 2e-3
