"""Doors with a schedule: obstacles change with time."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.simulation import MapChange, World

STAY = Decision(twist=np.zeros(3))
SHUT = ((6.0, 4.0, 6.2, 6.0),)


@pytest.fixture
def doored(make_setup, make_grid):
    """A door 4 m ahead of the chair that closes at 0.5 s and opens at 1 s."""
    floor, door = make_grid(), make_grid(boxes=SHUT)
    setup = make_setup(grid=floor, start=np.array([2.0, 5.0, 0.0]))
    changes = (MapChange(time=0.5, grid=door), MapChange(time=1.0, grid=floor))
    return replace(setup, changes=changes)


def ahead(world):
    """The range straight ahead in the newest scan, m."""
    scan = world.observe().scans[-1]
    return float(
        np.nanmin(
            scan.ranges[
                np.abs(scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))) < 0.05
            ]
        )
    )


def test_the_laser_and_the_referee_see_it_closed_from_then_until_then(doored):
    world = World(doored, 0)
    for k in range(30):
        time, shut = world.truth.time, 0.5 < world.truth.time < 1.04
        if world.observe().scans and k % 2 == 0 and k > 0:
            assert (ahead(world) < 4.2) == shut, time
        assert (world.truth.gap_wall < 4.0) == shut
        world.advance(STAY)


def test_it_waits_for_the_chair_and_for_people(doored, make_crowd):
    in_the_door = replace(doored, start=np.array([5.9, 5.0, 0.0]))
    world = World(in_the_door, 0)
    for _ in range(18):
        world.advance(STAY)
        assert not world.truth.hit_wall
        assert world.grid is doored.grid
    person = make_crowd([[6.1, 5.0]], [[[6.1, 5.0]]])
    world = World(replace(doored, crowd=person), 0)
    for _ in range(18):
        world.advance(STAY)
        assert world.grid is doored.grid


def test_driving_into_a_closed_door_is_a_contact(doored):
    go = Decision(twist=np.array([1.2, 0.0, 0.0]))
    closed = replace(doored, changes=doored.changes[:1])
    world, touched = World(closed, 0), False
    for _ in range(120):
        world.advance(go)
        touched |= world.truth.hit_wall
    assert touched
    free = World(replace(doored, changes=()), 0)
    for _ in range(120):
        free.advance(go)
        assert not free.truth.hit_wall


def test_nothing_else_changes_with_it(doored):
    """Chance has a generator for each purpose: the localiser errs as it would without doors."""
    one, two = World(doored, 3), World(replace(doored, changes=()), 3)
    for _ in range(30):
        np.testing.assert_array_equal(one.observe().pose, two.observe().pose)
        one.advance(STAY)
        two.advance(STAY)
