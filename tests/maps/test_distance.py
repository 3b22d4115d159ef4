"""The distance field against SciPy's exact transform, and its gradient against differences."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.ndimage import distance_transform_edt

from cohelm.maps import DistanceField, OccupancyGrid, distance_field, signed_distance


@given(blocked=hnp.arrays(bool, hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=40)))
def test_distances_between_cells_are_exact(blocked):
    assume(blocked.any() and not blocked.all())
    outside = distance_transform_edt(~blocked) - 0.5
    inside = 0.5 - distance_transform_edt(blocked)
    expected = 0.05 * np.where(blocked, inside, outside)
    # float32 holds 40·√2 cells of 0.05 m to 2e-7 m
    np.testing.assert_allclose(signed_distance(blocked, 0.05), expected, atol=4e-7)


def test_distances_are_exact_on_a_large_sparse_grid():
    blocked = np.random.default_rng(1).random((1500, 1100)) < 2e-5
    outside = distance_transform_edt(~blocked) - 0.5
    expected = np.where(blocked, -0.5, outside)
    np.testing.assert_allclose(signed_distance(blocked, 1.0), expected, rtol=2e-7, atol=1e-5)


def test_an_empty_grid_is_capped_at_its_diagonal():
    free = np.zeros((3, 4), dtype=bool)
    # 3-4-5: 5 cells, less the half cell; and inside a grid that is all obstacle the other way round
    assert signed_distance(free, 2.0) == pytest.approx(np.full((3, 4), 9.0))
    assert signed_distance(~free, 2.0) == pytest.approx(np.full((3, 4), -9.0))


def test_the_surface_is_the_edge_of_the_cell():
    data = np.zeros((5, 9), dtype=np.int8)
    data[:, :3] = 100  # a wall from x = 0 to 3 cells of 0.1 m
    field = distance_field(OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3)))
    x = np.array([0.15, 0.25, 0.28, 0.30, 0.32, 0.40, 0.77])
    points = np.stack([x, np.full_like(x, 0.21)], axis=-1)
    assert field.at(points) == pytest.approx(x - 0.30, abs=1e-6)
    assert field.with_gradient(points)[:, 1:] == pytest.approx(
        np.tile([1.0, 0.0], (7, 1)), abs=1e-5
    )


def test_unknown_counts_as_an_obstacle():
    grid = OccupancyGrid(
        data=np.array([[0, 0, -1]], dtype=np.int8), resolution=1.0, X_MG=np.zeros(3)
    )
    assert distance_field(grid).distance.tolist() == [[1.5, 0.5, -0.5]]


@given(
    seed=st.integers(0, 2**32 - 1),
    yaw=st.floats(-np.pi, np.pi),
    resolution=st.floats(0.02, 0.5),
)
def test_the_gradient_is_the_slope_of_the_value(seed, yaw, resolution):
    rng = np.random.default_rng(seed)
    field = DistanceField(
        distance=rng.normal(size=(6, 8)).astype(np.float32),
        resolution=resolution,
        X_MG=np.array([3.0, -2.0, yaw]),
    )
    # Points well inside a cell of the interpolation, so that no difference crosses its border.
    cells = rng.integers([0, 0], [5, 7], size=(20, 2)) + rng.uniform(0.1, 0.9, size=(20, 2))
    grid = OccupancyGrid(
        data=np.zeros((6, 8), dtype=np.int8), resolution=resolution, X_MG=field.X_MG
    )
    points = grid.centres(cells)
    step = 1e-3 * resolution
    found = field.with_gradient(points)
    assert found[:, 0] == pytest.approx(field.at(points))
    for axis in (0, 1):
        e = step * np.eye(2)[axis]
        slope = (field.at(points + e) - field.at(points - e)) / (2.0 * step)
        assert found[:, 1 + axis] == pytest.approx(slope, rel=1e-6, abs=1e-6 / resolution)


def test_beyond_the_border_the_nearest_value_holds_and_any_shape_of_points_goes():
    field = DistanceField(
        distance=np.array([[1.0, 2.0], [3.0, 4.0]], dtype=np.float32),
        resolution=1.0,
        X_MG=np.zeros(3),
    )
    assert field.at(np.array([[[-5.0, -5.0], [9.0, 9.0]]])).tolist() == [[1.0, 4.0]]
    assert field.at(np.array([1.0, 1.0])) == pytest.approx(2.5)
    assert field.at(np.empty((0, 2))).shape == (0,)


def test_a_field_of_a_single_cell_can_be_sampled():
    field = DistanceField(
        distance=np.array([[0.7]], dtype=np.float32), resolution=1.0, X_MG=np.zeros(3)
    )
    assert field.with_gradient(np.array([0.2, 0.9])) == pytest.approx([0.7, 0.0, 0.0])
