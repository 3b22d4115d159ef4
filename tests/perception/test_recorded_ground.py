"""The ground map on sweeps of real sensors, against kerbs and roads that were drawn by hand."""

from dataclasses import dataclass

import numpy as np
import pytest
from matplotlib.path import Path as Outline

from cohelm.evaluation.perception.ground_view import GRID, RecordedGround
from cohelm.perception.ground.cells import LOWER
from cohelm.recordings import open_recording
from cohelm.recordings.outside_data import outside_file
from cohelm.robots import load_robot

NEAR = 0.25
"""Distance of an edge from a kerb within which the kerb counts as found, m."""


@dataclass(frozen=True)
class Street:
    """Drawn over a picture of the raw heights, without the map's."""

    kerbs: tuple
    """Lines ((x, y), …), m, sensor's frame."""
    floors: tuple
    """Outlines of floor without any step."""


STREETS = {
    "kitti_obj_000000.bin": Street(
        kerbs=(((-7, 4.1), (-3, 4.25)), ((-2, 4.5), (1, 4.5)), ((-5, -4.5), (-0.6, -4.7))),
        floors=(
            ((4.7, -2), (8, -3), (8, 3), (4.7, 2)),
            ((-5.5, 2.4), (-4, 2.4), (-3.8, 3.6), (-5.5, 3.6)),
        ),
    ),
    "udacity_0000000000.pcd": Street(
        kerbs=(
            ((-0.3, 5), (6.3, 5)),
            ((-8, -1.65), (-5.3, -1.6)),
            ((4.2, -1.4), (8, -1.4)),
            ((1.8, -3.4), (3.6, -3.4)),
        ),
        floors=(
            ((4.9, -0.9), (7.8, -0.9), (7.8, 3.5), (4.9, 3.5)),
            ((-4, -6.4), (3, -6.5), (3, -5.2), (-4, -5.2)),
            ((-8, 0.5), (-5.7, 0.5), (-5.7, 4), (-8, 4)),
        ),
    ),
    "udacity_0000000007.pcd": Street(
        kerbs=(
            ((-6.2, 4.9), (-1.5, 4.95)),
            ((-8, -1.6), (-5.3, -1.6)),
            ((3.7, -1.35), (8, -1.4)),
            ((-7.2, -3.5), (-4, -3.5)),
        ),
        floors=(
            ((4.9, -0.9), (7.5, -0.9), (7.5, 2.5), (4.9, 2.3)),
            ((-8, -1), (-5.6, -1), (-5.6, 1.6), (-8, 1.6)),
            ((3, -6.8), (4.3, -6.8), (6, -4.5), (3, -4)),
        ),
    ),
}


def scored(name):
    """Share of the kerbs that was found, and of the floor that counts as behind an edge."""
    file = outside_file("lidar", name)
    if file is None:
        pytest.skip("COHELM_DATA does not name the recordings")
    found = RecordedGround(load_robot("quantum_q6_edge_lidar"), 8.0, only=True)
    for frame in open_recording(file):
        found.add(frame)
    ground, street = found.ground, STREETS[name]
    edges = GRID.centres(ground.edges.cells)
    hits = []
    for a, b in street.kerbs:
        along = np.linspace(a, b, int(np.hypot(*np.subtract(b, a)) / 0.05))
        away = np.linalg.norm(along[:, None] - edges, axis=2).min(axis=1)
        hits += (away <= NEAR).tolist()
    known = np.argwhere((ground.seen > 0) | (ground.kind >= LOWER))
    points = GRID.centres(known + ground.corner)
    inside = np.any([Outline(each).contains_points(points) for each in street.floors], axis=0)
    wrong = ground.kind[tuple(known[inside].T)] >= LOWER
    return float(np.mean(hits)), float(np.mean(wrong))


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "found", "wrong"),
    [
        ("kitti_obj_000000.bin", 0.9, 0.01),
        ("udacity_0000000000.pcd", 0.9, 0.01),
        ("udacity_0000000007.pcd", 0.9, 0.01),
    ],
)
def test_kerbs_of_real_streets_are_found_and_roads_are_floor(name, found, wrong):
    kerbs, floor = scored(name)
    assert kerbs >= found
    assert floor <= wrong
