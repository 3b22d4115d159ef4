"""The footprint against blocked cells: exact by separating axes, and swept without gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.planning.floors import CHAIR

from cohelm.geometry import distance_to_polygon, inside_polygon, transform
from cohelm.maps import signed_distance
from cohelm.planning.path_refinement.footprint import (
    footprint_model,
    overlaps,
    overlaps_along,
    segment_overlaps,
    triangulate,
    turn_overlaps,
)

RES = 0.05
SHAPES = {
    "chair": CHAIR.outline,
    "triangle": np.array([[0.5, 0.0], [-0.2, 0.3], [-0.2, -0.3]]),
    # A forklift: two prongs, and nothing between them.
    "fork": np.array(
        [
            [0.6, 0.3],
            [0.1, 0.3],
            [-0.3, 0.3],
            [-0.3, -0.3],
            [0.6, -0.3],
            [0.6, -0.2],
            [0.1, -0.2],
            [0.1, 0.2],
            [0.6, 0.2],
        ]
    ),
}


def area(polygon):
    x, y = np.moveaxis(polygon, -1, 0)
    return 0.5 * (x * np.roll(y, -1, axis=-1) - np.roll(x, -1, axis=-1) * y).sum(axis=-1)


def apart(polygon, square):
    """Whether two convex polygons have an axis that separates them."""
    for shape in (polygon, square):
        for edge in np.roll(shape, -1, axis=0) - shape:
            normal = np.array([edge[1], -edge[0]])
            a, b = polygon @ normal, square @ normal
            if a.max() <= b.min() + 1e-9 or b.max() <= a.min() + 1e-9:
                return True
    return False


def hits(outline, blocked, pose):
    """The oracle: any triangle of the outline against any blocked square."""
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    pieces = transform(pose, triangulate(outline))
    for row, col in np.argwhere(blocked):
        cell = (square + np.array([col, row])) * RES
        if any(not apart(piece, cell) for piece in pieces):
            return True
    return False


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_make_up_the_outline(name):
    outline = SHAPES[name]
    pieces = triangulate(outline)
    assert len(pieces) == len(outline) - 2
    assert (area(pieces) > 0.0).all()
    assert area(pieces).sum() == pytest.approx(area(outline))
    points = np.random.default_rng(0).uniform(-0.7, 0.7, (300, 2))
    clear = np.array([abs(distance_to_polygon(outline, *p)) for p in points]) > 1e-6
    covered = np.any([inside_polygon(piece, points) for piece in pieces], axis=0)
    # Points on a cut between two triangles lie in neither; none was drawn there.
    assert np.array_equal(covered[clear], inside_polygon(outline, points)[clear])


def test_an_outline_that_crosses_itself_is_refused():
    with pytest.raises(ValueError, match="crosses itself"):
        triangulate(np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [-0.5, 0.5]])[::-1])


@settings(max_examples=150, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    heading=st.sampled_from([0.0, np.pi / 2, np.pi / 4, np.pi / 6, -2.0, 3.0]),
    name=st.sampled_from(sorted(SHAPES)),
)
def test_overlap_is_exact(seed, heading, name):
    rng = np.random.default_rng(seed)
    blocked = rng.random((40, 44)) < 0.003
    pose = np.array([*rng.uniform(0.3, 1.7, 2), heading])
    if rng.random() < 0.5:
        pose[:2] = np.round(pose[:2] / RES) * RES  # sides on the cells' edges: touching is free
    body = footprint_model(SHAPES[name], signed_distance(blocked, RES), RES)
    assert overlaps(body, *pose) == hits(SHAPES[name], blocked, pose)


def test_nothing_stands_beyond_the_map():
    body = footprint_model(CHAIR.outline, signed_distance(np.zeros((20, 20), dtype=bool), RES), RES)
    assert not overlaps(body, 0.1, 0.1, 0.0)


def test_clearance_is_not_trusted_beyond_what_it_knows():
    # A live obstacle 0.5 m ahead, of which the field says nothing at the chair's own place.
    blocked = np.zeros((60, 60), dtype=bool)
    blocked[30, 40] = True
    field = signed_distance(blocked, RES)
    field[field > 0.3] = 5.0
    pose = (1.525, 1.525, 0.0)  # the front is at 2.175, the obstacle from 2.0 to 2.05
    assert overlaps(footprint_model(CHAIR.outline, field, RES, trust=0.3), *pose)
    assert not overlaps(footprint_model(CHAIR.outline, field, RES), *pose)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_sweep_misses_nothing_between_its_poses(seed):
    rng = np.random.default_rng(seed)
    blocked = rng.random((60, 60)) < 0.002
    body = footprint_model(CHAIR.outline, signed_distance(blocked, RES), RES)
    slim = footprint_model(0.98 * CHAIR.outline, body.clearance, RES)
    x, y, heading = *rng.uniform(1.0, 2.0, 2), rng.uniform(-3.0, 3.0)
    turn = rng.uniform(-1.5, 1.5)
    met = any(overlaps(slim, x, y, heading + turn * t) for t in np.linspace(0, 1, 400))
    assert turn_overlaps(body, x, y, heading, turn) >= met
    end = np.array([x, y]) + rng.uniform(-0.3, 0.3, 2)
    way = [np.array([x, y]) + t * (end - [x, y]) for t in np.linspace(0, 1, 400)]
    met = any(
        overlaps(slim, *p, heading + 0.3 * t)
        for p, t in zip(way, np.linspace(0, 1, 400), strict=True)
    )
    assert segment_overlaps(body, x, y, *end, heading, heading + 0.3) >= met


def test_a_line_tells_where_it_meets_something():
    blocked = np.zeros((60, 120), dtype=bool)
    blocked[38, 60:62] = True  # 0.4 m beside: a turn's corner meets it
    body = footprint_model(CHAIR.outline, signed_distance(blocked, RES), RES)
    straight = np.stack([np.arange(0.8, 5.2, 0.1), np.full(44, 1.5)], axis=-1)
    assert not overlaps_along(body, straight).any()
    corner = np.concatenate([straight[:24], [[3.1, 1.5 - 0.1 * k] for k in range(1, 8)]])
    at = np.flatnonzero(overlaps_along(body, corner))
    assert len(at)
    assert np.abs(corner[at] - [3.1, 1.5]).max() < 0.7
