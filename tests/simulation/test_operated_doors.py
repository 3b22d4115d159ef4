"""Doors operated by a person: seen by all sensors, and never closed on a person."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.simulation import ManualDoor, MapChange, World
from cohelm.simulation.dynamic_objects import with_shut_doors

STAY = Decision(twist=np.zeros(3))
WALL = ((6.0, 0.0, 6.2, 4.0), (6.0, 6.0, 6.2, 10.0))
DOOR = ManualDoor(a=np.array([6.1, 4.0]), b=np.array([6.1, 6.0]), depth=0.2)


@pytest.fixture
def doored(make_setup, make_grid):
    """A wall across the room with a door of 2 m in it, 4 m ahead of the chair."""
    return make_setup(grid=make_grid(boxes=WALL), doors=(DOOR,))


def advanced(world, count=1, decision=STAY):
    for _ in range(count):
        world.advance(decision)
    return world


def test_a_leaf_fills_its_opening_and_nothing_else(make_grid):
    """2 m of door in a wall 0.2 m thick at 0.05 m a cell: 40 by 4 cells."""
    grid = make_grid(boxes=WALL)
    shut = with_shut_doors(grid, (DOOR,))
    new = np.argwhere(shut.occupied() & ~grid.occupied())
    assert len(new) == 40 * 4
    np.testing.assert_array_equal([new.min(axis=0), new.max(axis=0)], [[80, 120], [119, 123]])
    assert not (grid.occupied() & ~shut.occupied()).any()


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0, 2.2])
def test_a_leaf_is_tight_however_it_lies(make_grid, turn):
    """No path of free cells, 8-connected, leads through the rectangle of a shut door."""
    grid = make_grid()
    half = np.array([np.cos(turn), np.sin(turn)])
    door = ManualDoor(a=np.array([6.0, 5.0]) - half, b=np.array([6.0, 5.0]) + half, depth=0.1)
    shut = with_shut_doors(grid, (door,))
    for along in np.linspace(-0.95, 0.95, 77):
        across = np.linspace(-0.4, 0.4, 33)[:, None] * np.array([-half[1], half[0]])
        cells = grid.cells(np.array([6.0, 5.0]) + along * half + across)
        assert shut.occupied()[cells[:, 0], cells[:, 1]].any()


def test_shut_and_open_again_is_the_floor_of_before(doored):
    world = World(doored, 0)
    assert world.set_door(0, shut=True)
    advanced(world)
    assert world.shut == {0}
    assert world.truth.gap_wall < 4.0
    shut = world.grid
    assert world.set_door(0, shut=False)
    assert advanced(world).grid is doored.grid
    world.set_door(0, shut=True)
    assert advanced(world).grid is shut  # remembered, with all that is derived from it


def test_chair_and_people_meet_it(doored, make_crowd):
    person = make_crowd([[5.0, 4.5]], [[[9.0, 4.5]]])
    world = World(replace(doored, crowd=person), 0)
    world.set_door(0, shut=True)
    touched = False
    for _ in range(160):
        world.advance(Decision(twist=np.array([1.0, 0.0, 0.0])))
        touched |= world.truth.hit_wall
    assert touched
    assert world.truth.crowd.position[0, 0] < 6.0


@pytest.mark.parametrize(("at", "shuts"), [(6.1, False), (5.7, False), (5.2, True)])
def test_it_does_not_shut_on_a_person(doored, make_crowd, at, shuts):
    """A body of 0.25 m has 0.1 m to the leaf, 6.0 m, from 5.65 m on."""
    person = make_crowd([[at, 5.0]], np.empty((1, 0, 2)))
    world = World(replace(doored, crowd=person), 0)
    assert world.set_door(0, shut=True) == shuts
    assert bool(world.shut) == shuts


def test_it_does_not_shut_on_the_chair_nor_where_it_cannot_stop(doored, robot):
    in_the_door = World(replace(doored, start=np.array([5.9, 5.0, 0.0])), 0)
    assert not in_the_door.set_door(0, shut=True)
    fast = World(doored, 0)
    go = Decision(twist=np.array([1.0, 0.0, 0.0]))
    refused = None
    while fast.truth.pose[0] + robot.outline[:, 0].max() < 5.9:
        trial = fast.set_door(0, shut=True)
        if not trial and refused is None:
            refused = 6.0 - (fast.truth.pose[0] + robot.outline[:, 0].max())
            speed = fast.truth.twist[0]
        fast.set_door(0, shut=False)
        fast.advance(go)
    needed = 0.1 + 0.2 * speed + speed**2 / (2.0 * robot.max_deceleration)
    assert refused == pytest.approx(needed, abs=0.12)  # a tick at 1 m/s, a cell, and steps of 0.1 m


def test_where_it_can_just_stop_it_touches_nothing(doored, robot):
    """Shut at the last moment at which it does, and braked from then on: no contact."""
    world = World(doored, 0)
    go = Decision(twist=np.array([1.0, 0.0, 0.0]))
    while True:
        ahead = World(doored, 0)
        advanced(ahead, round(world.truth.time / 0.05) + 1, go)
        if not ahead.set_door(0, shut=True):
            break
        world.advance(go)
    assert world.set_door(0, shut=True)
    for _ in range(60):
        world.advance(STAY)
        assert not world.truth.hit_wall


def test_a_timed_door_goes_its_own_way(doored, make_grid):
    other = make_grid(boxes=(*WALL, (9.0, 0.0, 9.2, 10.0)))
    changes = (MapChange(time=0.5, grid=other), MapChange(time=1.0, grid=doored.grid))
    world = World(replace(doored, changes=changes), 0)
    world.set_door(0, shut=True)
    seen = []
    for _ in range(30):
        world.advance(STAY)
        door, far = world.grid.cells([[6.1, 5.0], [9.1, 5.0]])
        occupied = world.grid.occupied()
        assert occupied[tuple(door)]
        seen.append(bool(occupied[tuple(far)]))
    assert seen == [False] * 10 + [True] * 10 + [False] * 10


def test_a_door_that_is_none_is_refused(doored):
    for number in (-1, 1, 99):
        with pytest.raises(IndexError, match="1 doors"):
            World(doored, 0).set_door(number, shut=True)
