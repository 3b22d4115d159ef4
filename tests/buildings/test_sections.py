"""Cells that meshes cover, against sums over points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.buildings.sections import Mesh, covered_cells, touched_cells
from cohelm.maps import OccupancyGrid

GRID = OccupancyGrid(data=np.zeros((40, 40), dtype=np.int8), resolution=0.05, X_MG=np.zeros(3))


def box(low, high, turned=0.0):
    x, y, z = ((a, b) for a, b in zip(low, high, strict=True))
    vertices = np.array([[i, j, k] for k in z for j in y for i in x], dtype=float)
    cos, sin = np.cos(turned), np.sin(turned)
    middle = (np.array(low) + high)[:2] / 2.0
    vertices[:, :2] = (vertices[:, :2] - middle) @ np.array([[cos, sin], [-sin, cos]]) + middle
    quads = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return Mesh(vertices=vertices, faces=np.array(faces))


def test_a_wall_on_the_lines_of_the_grid_fills_its_cells_only():
    cells = touched_cells([box((0.5, 0.5, 0.0), (1.0, 0.7, 3.0))], GRID, 0.05, 1.2)
    expected = np.zeros(GRID.shape, dtype=bool)
    expected[10:14, 10:20] = True
    assert np.array_equal(cells, expected)


@given(
    st.floats(0.3, 1.0), st.floats(0.3, 1.0), st.floats(0.1, 0.9), st.floats(0.1, 0.9),
    st.floats(0.0, np.pi),
)  # fmt: skip
def test_a_turned_box_marks_each_cell_that_it_reaches_into(x, y, width, depth, turned):
    cells = touched_cells([box((x, y, 0.0), (x + width, y + depth, 3.0), turned)], GRID, 0.05, 1.2)
    # Points of the box, 5 mm inside its faces, lie in marked cells, and all marked cells near it.
    u, v = np.meshgrid(np.linspace(0.006, width - 0.006, 60), np.linspace(0.006, depth - 0.006, 60))
    local = np.stack([u.ravel() - width / 2.0, v.ravel() - depth / 2.0], axis=1)
    cos, sin = np.cos(turned), np.sin(turned)
    points = local @ np.array([[cos, sin], [-sin, cos]]) + [x + width / 2.0, y + depth / 2.0]
    points = points[GRID.contains(points)]
    assert cells[tuple(GRID.cells(points).T)].all()
    centres = GRID.centres(np.argwhere(cells)) - [x + width / 2.0, y + depth / 2.0]
    back = np.abs(centres @ np.array([[cos, -sin], [sin, cos]]))
    assert np.all(back <= np.array([width, depth]) / 2.0 + 0.05 * np.sqrt(0.5) + 1e-6)


@pytest.mark.parametrize("flip", [False, True])
def test_the_orientation_of_triangles_does_not_matter(flip):
    mesh = box((0.5, 0.5, 0.0), (1.5, 1.5, 3.0))
    faces = mesh.faces.copy()
    if flip:
        faces[::3] = faces[::3, ::-1]
    cells = touched_cells([Mesh(vertices=mesh.vertices, faces=faces)], GRID, 0.05, 1.2)
    assert np.count_nonzero(cells) == 400


def test_only_the_part_in_the_band_counts():
    # A ramp from z = 0 at x = 0.5 to z = 2 at x = 1.5: it is between 0.5 and 1 from x 0.75 to 1.
    vertices = [[0.5, 0.5, 0.0], [1.5, 0.5, 2.0], [1.5, 1.0, 2.0], [0.5, 1.0, 0.0]]
    mesh = Mesh(vertices=np.array(vertices), faces=np.array([[0, 1, 2], [0, 2, 3]]))
    cells = touched_cells([mesh], GRID, 0.5, 1.0)
    assert np.flatnonzero(cells.any(axis=0)).tolist() == list(range(15, 20))
    assert np.flatnonzero(cells.any(axis=1)).tolist() == list(range(10, 20))


@pytest.mark.parametrize("along", [0, 1])
def test_a_sheet_without_thickness_is_there(along):
    ends = np.array([[0.52, 0.52, 0.0], [0.52, 0.52, 2.0], [0.52, 0.52, 2.0], [0.52, 0.52, 0.0]])
    ends[2:, along] = 1.48
    mesh = Mesh(vertices=ends, faces=np.array([[0, 1, 2], [0, 2, 3]]))
    cells = touched_cells([mesh], GRID, 0.05, 1.2)
    assert np.count_nonzero(cells) == 20


@pytest.mark.parametrize("along", [0, 1])
def test_a_thin_pane_in_a_thick_frame_is_there(along):
    low, high = np.array([0.521, 0.521, 0.0]), np.array([0.524, 0.524, 2.0])
    high[along] = 1.5
    post = box((0.5, 0.5, 0.0), (0.6, 0.6, 2.0))
    pane = box(low, high)
    both = Mesh(
        vertices=np.concatenate([post.vertices, pane.vertices]),
        faces=np.concatenate([post.faces, pane.faces + len(post.vertices)]),
    )
    assert np.count_nonzero(touched_cells([both], GRID, 0.05, 1.2)) == 4 + 18


def test_floor_counts_where_it_lies_below_the_centre_of_a_cell():
    floor = box((0.52, 0.49, -0.2), (1.0, 1.0, 0.0))
    cells = covered_cells(floor.triangles, GRID)
    assert np.flatnonzero(cells.any(axis=0)).tolist() == list(range(10, 20))
    assert np.flatnonzero(cells.any(axis=1)).tolist() == list(range(10, 20))


def test_nothing_gives_nothing():
    assert not touched_cells([], GRID, 0.0, 1.0).any()
    assert not covered_cells(np.empty((0, 3, 3)), GRID).any()
