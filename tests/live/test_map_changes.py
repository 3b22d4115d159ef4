"""Contradictions between map and building: kept over rides, and forgotten on request."""

import time

import numpy as np
import pytest

from cohelm.arrays import replace
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.health.map_changes import PERSISTENT
from cohelm.live import Drive, DriveSetup
from cohelm.live.messages import ReleaseControl
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.map_changes import (
    forget_changes,
    keep_changes,
    map_key,
    remembered_changes,
    stored_changes,
)
from cohelm.maps import OCCUPIED, OccupancyGrid
from cohelm.navigation import Navigator
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import World

from .test_drive import Page

GRID = OccupancyGrid(data=np.zeros((20, 30), dtype=np.int8), resolution=0.1, X_MG=np.zeros(3))
FOUND = MapChanges(np.array([[3, 4, 0], [5, 1, 1]]), np.array([PERSISTENT, 2]), time=12.5)


@pytest.fixture
def database(tmp_path):
    return Database(tmp_path)


def test_what_one_ride_has_seen_the_next_one_knows(database):
    assert remembered_changes(database, GRID) is NO_CHANGES
    keep_changes(database, GRID, "ward", FOUND)
    known = remembered_changes(database, GRID)
    assert known.cells.tolist() == FOUND.cells.tolist()
    assert known.balance.tolist() == FOUND.balance.tolist()
    assert known.time == -np.inf  # the clock of the next ride begins anew
    keep_changes(database, GRID, "ward", NO_CHANGES)  # it has found the map to be right again
    (stored,) = stored_changes(database).values()
    assert (stored.rides, stored.cells) == (2, ())


def test_a_map_is_known_by_its_content(database):
    keep_changes(database, GRID, "ward", FOUND)
    data = GRID.data.copy()
    data[3, 4] = OCCUPIED
    other = replace(GRID, data=data)
    assert map_key(other) != map_key(GRID) == map_key(replace(GRID, data=GRID.data.copy()))
    assert remembered_changes(database, other) is NO_CHANGES
    keep_changes(database, other, "annex", FOUND)
    assert forget_changes(database, map_key(GRID)) == 1
    assert [each.scene for each in stored_changes(database).values()] == ["annex"]
    assert forget_changes(database) == 1
    assert stored_changes(database) == {}


def test_a_ride_without_contradictions_on_an_unknown_map_writes_nothing(database):
    keep_changes(database, GRID, "ward", NO_CHANGES)
    assert not database.file.exists()


HUGE = """{"scene": "x", "updated": "", "rides": 1, "cells": [[1, 1, 1%s]], "balance": [1]}""" % (
    30 * "0"
)


@pytest.mark.parametrize("damage", ["", "{", "3", '{"rides": 0}', HUGE])
def test_a_damaged_entry_is_named_ends_no_drive_and_is_replaced(database, damage, caplog):
    database.set(f"map_changes:{map_key(GRID)}", damage)
    assert remembered_changes(database, GRID) is NO_CHANGES
    assert "is damaged" in caplog.text
    keep_changes(database, GRID, "ward", FOUND)
    assert len(stored_changes(database)) == 1


def test_a_ride_begins_with_what_earlier_rides_have_seen():
    """Behind the chair's horizon nothing speaks for or against it."""
    ride_setup = build_scenario(load_scenario("empty"), 0)
    far = MapChanges(np.array([[4000, 4000, 0]]), np.array([PERSISTENT]))
    navigator = Navigator(ride_setup.navigator).remembering(far)
    world, tick = World(ride_setup.world, 0), None
    for _ in range(3):
        tick = navigator.step(world.observe(), ride_setup.request, tick)
        world.advance(tick.decision)
    assert [4000, 4000, 0] in tick.memory.health.changes.cells.tolist()


@pytest.mark.slow
def test_a_live_ride_past_a_door_that_moved_is_remembered(tmp_path):
    """The map has a wall at (7, 7.5), where the building has a door; the old one is walled up."""
    drive = Drive(DriveSetup(scenario=load_scenario("moved-door"), folder=tmp_path))
    try:
        drive.start()
        end = time.monotonic() + 240.0
        while not drive.health.ready:
            assert time.monotonic() < end
            time.sleep(0.05)
        page = Page(drive, "a")
        page.drives()
        page.moves()
        _, begun = page.until(lambda s: True)
        page.until(lambda s: s.time - begun.time > 10.0, patience=120.0)
        page.rests()
        page.say(ReleaseControl())
        page.until(lambda s: s.driver is None)
        page.close()
    finally:
        drive.close()
    grid = build_scenario(load_scenario("moved-door"), 0).navigator.grid
    found = remembered_changes(Database(tmp_path), grid)
    door = np.array([7.0, 7.5])
    assert np.hypot(*(found.persistent(new=False) - door).T).min() < 0.6
    assert (found.cells[:, 2] == 1).any()  # the old door, no larger than people: only counted
