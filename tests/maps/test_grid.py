"""Laws of the grid's two frames."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.maps import OccupancyGrid

poses = st.tuples(st.floats(-100.0, 100.0), st.floats(-100.0, 100.0), st.floats(-np.pi, np.pi)).map(
    np.array
)


def grid(rows, cols, *, resolution=0.05, pose=(0.0, 0.0, 0.0)):
    return OccupancyGrid(
        data=np.zeros((rows, cols), dtype=np.int8), resolution=resolution, X_MG=np.array(pose)
    )


@given(
    pose=poses, resolution=st.floats(0.01, 1.0), rows=st.integers(1, 40), cols=st.integers(1, 40)
)
def test_the_centre_of_a_cell_lies_in_that_cell_however_the_origin_is_turned(
    pose, resolution, rows, cols
):
    g = grid(rows, cols, resolution=resolution, pose=pose)
    cells = np.stack(np.indices((rows, cols)), axis=-1)
    assert np.array_equal(g.cells(g.centres(cells)), cells)
    assert g.contains(g.centres(cells)).all()


@given(pose=poses)
def test_all_cells_lie_within_the_bounds(pose):
    g = grid(7, 11, resolution=0.5, pose=pose)
    centres = g.centres(np.stack(np.indices(g.shape), axis=-1))
    x0, y0, x1, y1 = g.bounds
    assert centres[..., 0].min() > x0
    assert centres[..., 0].max() < x1
    assert centres[..., 1].min() > y0
    assert centres[..., 1].max() < y1


def test_a_quarter_turn_by_hand():
    # Corner at (1, 2), turned by 90°: the grid's x axis points along the map's y axis, its y axis
    # along the map's −x. The centre of row 0, column 3 is (3.5, 0.5) cells, with 0.1 m a cell
    # (0.35, 0.05) m, which is (1 − 0.05, 2 + 0.35) in the map.
    g = grid(2, 5, resolution=0.1, pose=(1.0, 2.0, np.pi / 2))
    assert g.centres([0, 3]) == pytest.approx([0.95, 2.35])
    # 5 columns are 0.5 m along y, 2 rows 0.2 m along −x.
    assert g.bounds == pytest.approx((0.8, 2.0, 1.0, 2.5))


def test_unknown_and_more_than_half_occupied_block():
    g = OccupancyGrid(
        data=np.array([[-1, 0, 50, 51, 100]], dtype=np.int8), resolution=1.0, X_MG=np.zeros(3)
    )
    assert g.blocked().tolist() == [[True, False, False, True, True]]
    assert g.occupied().tolist() == [[False, False, False, True, True]]


def test_points_off_the_grid_have_cells_and_are_not_contained():
    g = grid(2, 2, resolution=1.0)
    points = np.array([[-0.1, 0.5], [0.5, 0.5], [2.0, 0.5], [1.999, 1.999]])
    assert g.cells(points).tolist() == [[0, -1], [0, 0], [0, 2], [1, 1]]
    assert g.contains(points).tolist() == [False, True, False, True]
