"""Beams against the map: a room of 8 × 6 m with people in it, and poses that are wrong."""

import numpy as np
import pytest

from cohelm.health import HealthParameters
from cohelm.health.map_fit import HIT, MISSING, SHORT, THROUGH, BeamTable, beam_map, fit_map
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, distance_field

RESOLUTION = 0.05
ANGLES = np.arange(120) * 2.0 * np.pi / 120


def room(shade=FREE):
    data = np.full((140, 180), shade, dtype=np.int8)
    data[10:130, 10:170] = FREE
    for rows, cols in ((slice(8, 10), slice(8, 172)), (slice(130, 132), slice(8, 172))):
        data[rows, cols] = OCCUPIED
    data[8:132, 8:10] = data[8:132, 170:172] = OCCUPIED
    return OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.array([-0.5, -0.5, 0.0]))


GRID = room()
KNOWN = beam_map(GRID, distance_field(GRID))


def ranges_at(pose):
    """Exact ranges (n,) to the walls of the room, which spans 0…8 and 0…6 m."""
    a = pose[2] + ANGLES
    with np.errstate(divide="ignore"):
        x = np.where(np.cos(a) > 0, 8.0 - pose[0], -pose[0]) / np.cos(a)
        y = np.where(np.sin(a) > 0, 6.0 - pose[1], -pose[1]) / np.sin(a)
    return np.minimum(np.abs(x), np.abs(y))


def fit(true, reported, change=None):
    ranges = ranges_at(true)
    if change is not None:
        ranges = change(ranges)
    beams = BeamTable(ANGLES, ranges, np.ones(120, dtype=bool))
    return fit_map(KNOWN, beams, np.array(reported, dtype=float), 10.0, 0.15)


POSE = [3.0, 2.0, 0.4]


def test_at_the_right_pose_every_beam_hits_its_wall():
    found = fit(POSE, POSE)
    assert found.hit == 120
    assert found.contradiction == 0.0
    # the walls are two cells thick, and their surface lies within one of them
    np.testing.assert_allclose(found.expected, ranges_at(POSE), atol=2.5 * RESOLUTION)


def test_a_crowd_hides_walls_and_contradicts_nothing():
    found = fit(POSE, POSE, lambda r: np.where(np.arange(120) % 4 > 0, 0.6 * r, r))
    assert found.short == 90
    assert found.contradiction == 0.0


def test_walls_that_are_passed_or_missed_contradict_the_pose():
    through = fit(POSE, POSE, lambda r: np.where(np.arange(120) < 30, r + 1.0, r))
    assert (through.beams[1:29] == THROUGH).all()
    missing = fit(POSE, POSE, lambda r: np.where(np.arange(120) < 30, np.inf, r))
    assert (missing.beams[:30] == MISSING).all()
    assert missing.contradiction == pytest.approx(0.25)


@pytest.mark.parametrize("shift", [(3.0, 0.0), (0.0, 1.5), (2.5, 2.0)])
def test_a_wrong_place_is_contradicted(shift):
    wrong = [POSE[0] + shift[0], POSE[1] + shift[1], POSE[2]]
    # the wall behind is passed by the beams that see it: more the farther the pose is wrong
    assert fit(POSE, wrong).contradiction > HealthParameters().doubtful_share


@pytest.mark.parametrize("error", [(0.2, 0.0, 0.0), (0.0, -0.25, 0.0), (0.1, 0.1, 0.1)])
def test_the_best_offset_is_the_error_of_the_pose(error):
    found = fit(POSE, np.array(POSE) + error)
    np.testing.assert_allclose(found.offset, -np.array(error), atol=0.04)


def test_rotating_the_map_rotates_the_offset():
    turned = OccupancyGrid(
        data=GRID.data, resolution=RESOLUTION, X_MG=np.array([0.5, -0.5, np.pi / 2])
    )
    known = beam_map(turned, distance_field(turned))
    # the map's corner (0, 0) stays, x becomes y and y becomes −x
    pose = np.array([-POSE[1], POSE[0], POSE[2] + np.pi / 2])
    beams = BeamTable(ANGLES, ranges_at(POSE), np.ones(120, dtype=bool))
    found = fit_map(known, beams, pose + np.array([0.0, 0.2, 0.0]), 10.0, 0.15)
    assert found.hit + found.short + found.through == 120
    np.testing.assert_allclose(found.offset, [0.0, -0.2, 0.0], atol=0.04)


def test_unknown_cells_expect_nothing():
    data = GRID.data.copy()
    data[60:80, 150:172] = UNKNOWN  # a part of the right wall that nobody mapped
    grid = OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=GRID.X_MG)
    beams = BeamTable(np.zeros(1), np.array([np.inf]), np.ones(1, dtype=bool))
    known = beam_map(grid, distance_field(grid))
    found = fit_map(known, beams, np.array([3.0, 3.0, 0.0]), 10.0, 0.15)
    assert np.isnan(found.expected[0])
    assert found.beams[0] not in {MISSING, THROUGH, HIT, SHORT}
