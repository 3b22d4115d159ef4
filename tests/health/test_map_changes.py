"""Persistent contradictions between map and sweeps, as a report."""

import numpy as np

from cohelm.health.map_changes import CELL, NO_CHANGES, PERSISTENT, update_map_changes
from cohelm.health.map_fit import BeamTable, fit_map

from .test_map_fit import ANGLES, KNOWN, POSE, ranges_at

AHEAD = slice(0, 8)
"""Beams towards the same wall."""


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
    out[AHEAD] *= 0.5
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


def test_an_obstacle_is_reported_and_taken_back_when_beams_pass_it():
    standing = after(PERSISTENT, new)
    assert len(standing.persistent(new=True))
    assert not len(after(PERSISTENT + 1, lambda r: r, standing).persistent(new=True))


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
