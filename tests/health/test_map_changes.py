"""Persistent contradictions between map and sweeps, as a report."""

import numpy as np

from cohelm.health.map_changes import (
    CELL,
    NO_CHANGES,
    PERSISTENT,
    MapChanges,
    standing_people,
    update_map_changes,
    updated_map,
    without_people,
)
from cohelm.health.map_fit import HIT, BeamTable, beam_map, fit_map
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, distance_field

from .test_map_fit import ANGLES, KNOWN, POSE, ranges_at

AHEAD = slice(0, 8)
"""Beams towards the same wall."""
WIDE = slice(0, 12)
"""Beams to an obstacle that is larger than people."""


def after(sweeps, change, changes=NO_CHANGES):
    beams = BeamTable(ANGLES, change(ranges_at(POSE)), np.ones(len(ANGLES), dtype=bool))
    fit = fit_map(KNOWN, beams, np.array(POSE), 10.0, 0.15)
    start = changes.time if np.isfinite(changes.time) else -0.5
    for k in range(sweeps):
        time = start + 0.5 * (k + 1)
        changes = update_map_changes(changes, fit, beams, np.array(POSE), np.zeros(3), time)
    return changes


def gone(ranges):
    out = ranges.copy()
    out[AHEAD] += 1.5
    return out


def new(ranges):
    out = ranges.copy()
    out[WIDE] *= 0.5
    return out


def test_a_true_map_has_no_contradictions():
    changes = after(3 * PERSISTENT, lambda r: r)
    assert not len(changes.cells)


def test_a_wall_that_is_gone_is_reported_where_it_stood():
    found = after(PERSISTENT, gone).persistent(new=False)
    assert 1 <= len(found) <= 8
    distance = np.hypot(*(found - POSE[:2]).T)
    walls = ranges_at(POSE)[AHEAD]
    assert np.all((distance > walls.min() - 2 * CELL) & (distance < walls.max() + 2 * CELL))
    assert not len(after(PERSISTENT - 1, gone).persistent(new=False))


def test_a_wall_that_is_gone_is_reported_although_beams_end_on_the_next_one():
    """A door in a wall between two rooms: behind it beams end where the map has walls again."""
    grid = np.zeros((100, 100), dtype=np.int8)
    grid[:, [40, 80]] = OCCUPIED
    floor = OccupancyGrid(data=grid, resolution=0.1, X_MG=np.zeros(3))
    known = beam_map(floor, distance_field(floor))
    angles, pose = np.radians(np.arange(-40.0, 41.0, 2.0)), np.array([2.0, 5.0, 0.0])
    door = np.abs(angles) < np.radians(14.0)  # 1 m wide, at x = 4 m
    ranges = np.where(door, 6.05, 2.05) / np.cos(angles)
    beams = BeamTable(angles, ranges, np.ones(len(angles), dtype=bool))
    fit, changes = fit_map(known, beams, pose, 10.0, 0.15), NO_CHANGES
    assert (fit.beams == HIT).all()
    for k in range(PERSISTENT):
        changes = update_map_changes(changes, fit, beams, pose, np.zeros(3), 0.5 * k)
    found = changes.persistent(new=False)
    np.testing.assert_allclose(found[:, 0], 4.125)
    assert 4.4 < found[:, 1].min() < found[:, 1].max() < 5.6
    assert not len(changes.persistent(new=True))


def test_an_obstacle_is_reported_and_taken_back_when_beams_pass_it():
    standing = after(PERSISTENT, new)
    assert len(standing.persistent(new=True))
    assert not len(after(PERSISTENT + 1, lambda r: r, standing).persistent(new=True))


def test_who_stood_there_was_no_obstacle():
    standing = after(PERSISTENT, new)
    places = standing.persistent(new=True)
    assert not len(without_people(standing, places).cells)
    assert without_people(standing, places + 20.0).cells.tolist() == standing.cells.tolist()
    assert without_people(standing, np.empty((0, 2))) is standing


def test_what_is_no_larger_than_people_is_counted_and_not_reported():
    """Three who stand and talk, and a wall of 1.5 m; without an outline both are only returns."""
    people = [(0, 0, 1), (1, 0, 1), (3, 0, 1), (3, 1, 1), (1, 2, 1), (2, 3, 1)]
    wall = [(20, row, 1) for row in range(6)]
    changes = MapChanges(np.array([*people, *wall, (9, 9, 0)]), np.full(13, 2 * PERSISTENT))
    assert sorted(map(tuple, changes.persistent_rows.tolist())) == sorted([*wall, (9, 9, 0)])
    assert len(changes.persistent(new=True)) == 6


def test_who_stands_is_remembered_for_a_while_and_who_walks_is_not():
    stands, walks = (1.0, 2.0, 0.1, 0.0), (5.0, 5.0, 1.0, 0.0)
    none = np.empty((0, 4))
    known = standing_people(np.empty((0, 3)), np.array([stands, walks]), 10.0)
    assert known.tolist() == [[1.0, 2.0, 10.0]]
    assert standing_people(known, none, 40.0).tolist() == known.tolist()
    assert not len(standing_people(known, none, 71.0))
    assert not len(standing_people(known, none, 0.0))  # the clock of another ride
    again = standing_people(known, np.array([stands]), 40.0)
    assert again.tolist() == [[1.0, 2.0, 40.0]]


def test_a_wall_that_is_gone_stays_gone_when_somebody_stands_there():
    missing = after(PERSISTENT, gone)
    walls = missing.persistent(new=False)
    assert without_people(missing, walls).persistent(new=False).tolist() == walls.tolist()


def test_sweeps_in_quick_succession_count_once():
    once = after(1, new)
    fit = fit_map(
        KNOWN,
        BeamTable(ANGLES, new(ranges_at(POSE)), np.ones(len(ANGLES), dtype=bool)),
        np.array(POSE),
        10.0,
        0.15,
    )
    beams = BeamTable(ANGLES, new(ranges_at(POSE)), np.ones(len(ANGLES), dtype=bool))
    again = update_map_changes(once, fit, beams, np.array(POSE), np.zeros(3), once.time + 0.1)
    assert again is once


def test_the_updated_map_has_the_changes_and_nothing_else():
    resolution = 0.05
    data = np.zeros((40, 40), dtype=np.int8)
    data[:, 20] = OCCUPIED  # a wall at 1.0 m
    data[0, :] = UNKNOWN
    grid = OccupancyGrid(data=data, resolution=resolution, X_MG=np.array([0.5, 0.0, 0.0]))
    # Cells of 0.25 m: x 1.5 to 1.75, and 0.75 to 1.0 with y to 1.5; a small one may be a person.
    gone, new, small = (6, 3, 0), [(3, row, 1) for row in range(6)], (9, 7, 1)
    changes = MapChanges(np.array([gone, *new, small]), np.full(8, PERSISTENT))
    updated = updated_map(grid, changes)
    assert np.array_equal(grid.data, data)
    expected = data.copy()
    expected[15:20, 20] = FREE
    expected[1:30, 5:10] = OCCUPIED  # the unknown row stays unknown
    assert np.array_equal(updated.data, expected)
    doubtful = changes._replace(balance=np.full(8, PERSISTENT - 1))
    assert np.array_equal(updated_map(grid, doubtful).data, data)
