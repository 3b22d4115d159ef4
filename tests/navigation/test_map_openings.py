"""Walls of the map that the scan passes open to a rider who pushes on, and to nobody else."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cohelm.evaluation import run
from cohelm.evaluation.episode.ride import Outcome
from cohelm.maps import distance_field
from cohelm.navigation.map_openings import CLOSED, update_openings, with_openings
from cohelm.perception import Detections
from cohelm.scenarios import load_scenario
from cohelm.testing.scenes import room

WALL = [(6.0, 0.0, 6.1, 8.0)]
GRID = room(boxes=WALL)
OPENABLE = GRID.occupied()
SENSOR = np.array([5.2, 4.0])
DOOR = (3.5, 4.5)
"""Gap in the true wall, m."""


def sweep(time, *, door=DOOR, closed_at=None):
    """A sweep from before the wall; beams through the door end 3 m behind, the others at the wall.

    closed_at: x of something in the door.
    """
    angles = np.radians(np.arange(-60.0, 61.0, 0.5))
    y = SENSOR[1] + 0.8 * np.tan(angles)
    far = SENSOR[1] + 0.9 * np.tan(angles)
    through = (far > door[0]) & (far < door[1])
    at_wall = np.column_stack([np.full(len(y), 6.02), y])
    behind = SENSOR + 3.8 * np.column_stack([np.ones(len(y)), np.tan(angles)])
    ends = np.where(through[:, None], behind, at_wall)
    if closed_at is not None:
        inside = SENSOR + (closed_at - SENSOR[0]) * np.column_stack(
            [np.ones(len(y)), np.tan(angles)]
        )
        ends = np.where(through[:, None], inside, ends)
    none = np.full(len(ends), -1, dtype=np.int64)
    return replace(
        Detections.empty(time, SENSOR),
        points=ends,
        detection_of_return=none,
        cluster_of_return=none,
        mapped=np.zeros(len(ends), dtype=np.bool_),
    )


def swept(
    seconds, *, pushes=True, held_since=0.0, before=CLOSED, start=0.0, openable=OPENABLE, **of
):
    """Openings after sweeps at 10 Hz."""
    now = before
    for k in range(round(10 * seconds)):
        time = start + 0.1 * (k + 1)
        now = update_openings(
            now, (sweep(time, **of),), GRID, openable, pushes=pushes, held_since=held_since
        )
    return now


def opened_span(openings):
    """Rows of the cells that are open, as y, m."""
    rows = openings.opened.codes // GRID.shape[1]
    return 0.05 * rows.min(), 0.05 * (rows.max() + 1)


def test_a_push_that_is_held_opens_what_the_scan_passes():
    assert not len(swept(0.9).opened.codes)
    low, high = opened_span(swept(1.1))
    assert (low, high) == pytest.approx(DOOR, abs=0.06)
    assert swept(1.1).slow_until > 4.0


def test_without_a_push_or_while_the_chair_moves_nothing_opens():
    assert swept(3.0, pushes=False) is CLOSED
    moving = swept(3.0, held_since=math.inf)
    assert not len(moving.opened.codes)
    # … but such a wall is known not to be seen
    assert len(moving.seen.codes)


def test_keepout_zones_never_open():
    closed = OPENABLE.copy()
    closed[:, 115:130] = False
    assert not len(swept(3.0, openable=closed).seen.codes)


def test_a_released_stick_forgets_what_was_counted_but_not_what_is_open():
    counted = swept(0.8)
    assert len(counted.passed)
    assert swept(0.1, pushes=False, before=counted, start=0.8) is CLOSED
    opened = swept(1.1)
    later = swept(2.0, pushes=False, held_since=math.inf, before=opened, start=1.1)
    assert len(later.opened.codes) >= len(opened.opened.codes)


def test_what_stands_in_the_opening_closes_it():
    opened = swept(1.1)
    after = swept(0.1, before=opened, start=1.1, held_since=math.inf, closed_at=6.07)
    assert len(after.opened.codes) < len(opened.opened.codes)
    rows, cols = np.divmod(after.opened.codes, GRID.shape[1])
    assert not ((cols == 121) & (np.abs(0.05 * rows - 4.0) < 0.3)).any()


def test_beams_without_a_return_open_nothing():
    blind = replace(Detections.empty(0.0, SENSOR), free_ends=sweep(0.0).points)
    now = CLOSED
    for k in range(30):
        found = replace(blind, time=0.1 * (k + 1))
        now = update_openings(now, (found,), GRID, OPENABLE, pushes=True, held_since=0.0)
    assert not len(now.seen.codes)


def test_a_wall_that_the_scan_sees_never_opens():
    assert not len(swept(3.0, door=(4.0, 4.0)).seen.codes)


def test_nothing_that_changes_is_the_same_object():
    opened = swept(3.0)
    after = swept(0.5, before=opened, start=3.0)
    assert after.opened is opened.opened
    assert after.seen is opened.seen


def test_the_field_with_openings_is_that_of_the_changed_map():
    opened = swept(1.1).opened
    data = GRID.data.copy()
    data.reshape(-1)[opened.codes] = 0
    static, true = distance_field(GRID), distance_field(replace(GRID, data=data)).distance
    corner = np.array([20, 60])
    window = static.distance[20:140, 60:200]
    found = with_openings(window, corner, static, opened)
    truth = true[20:140, 60:200]
    # Far from the opening it may be less, as far as the changed part of the field is cut off.
    assert (found <= truth + 1e-5).all()
    assert np.abs(found - truth)[truth < 1.5].max() < 1e-5
    assert (truth - window).max() > 0.4
    assert with_openings(window, corner, static, CLOSED.opened) is window


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["assisted", "shared"])
def test_a_rider_gets_through_a_door_that_the_map_does_not_have(mode):
    ride = run(load_scenario("moved-door", [f"mode={mode}"]), 0)
    assert ride.outcome is Outcome.REACHED
    assert not ride.hit_wall.any()
    slow = (ride.pose[:, 0] > 6.1) & (ride.pose[:, 0] < 6.3)  # front at the mapped wall
    assert ride.twist[slow, 0].max() < 0.13


@pytest.mark.slow
def test_without_a_rider_the_mapped_wall_stays():
    settings = ["mode=autonomous", "rider.use=none", "time_limit=40"]
    ride = run(load_scenario("moved-door", settings), 0)
    assert ride.pose[:, 0].max() < 6.5
