"""Who is added to a scene stands where there is room, and comes to where they are wanted."""

import itertools

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.geometry import nearest_on_polyline
from cohelm.live.control import added_people as simulated
from cohelm.live.control.added_people import (
    NoFreeSpace,
    crossing_pedestrian,
    new_pedestrian,
    walkable_floor,
)
from cohelm.live.floor_model import floor_model
from cohelm.maps import distance_field
from cohelm.messages import Decision
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import World, generator

STAY = Decision(twist=np.zeros(3))


@pytest.fixture(scope="module")
def ride_setup():
    return build_scenario(load_scenario("hospital"), 2)


@pytest.fixture(scope="module")
def floor(ride_setup):
    return walkable_floor(ride_setup)


@pytest.fixture
def world(ride_setup):
    return World(ride_setup.world, ride_setup.seed)


def chance(seed=0):
    return generator(seed, "added")


def gaps(world):
    """From each body to the others, the chair and the walls, the least, m."""
    truth, crowd = world.truth, world.truth.crowd
    apart = np.hypot(*(crowd.position[:, None] - crowd.position[None]).transpose(2, 0, 1))
    apart -= crowd.radius[:, None] + crowd.radius[None]
    np.fill_diagonal(apart, np.inf)
    walls = distance_field(world.grid).at(crowd.position) - crowd.radius
    return min(apart.min(), truth.gap_people.min(), walls.min())


def test_whoever_comes_touches_neither_walls_nor_anybody(ride_setup, floor, world):
    rng = chance()
    for k in range(30):
        if k % 2:
            world.spawn(new_pedestrian(floor, world.truth, None, rng))
        else:
            world.spawn(crossing_pedestrian(floor, world.truth, ride_setup.route.points, rng))
        assert gaps(world) > 0.05


def test_they_come_near_the_point_that_was_asked_for_and_walk_to_a_place(floor, world):
    point = np.array([20.0, 8.0])
    newcomer = new_pedestrian(floor, world.truth, point, chance())
    assert np.hypot(*(newcomer.position - point)) < 0.2
    assert newcomer.loop
    to_places = np.hypot(*(newcomer.waypoints[:, None] - floor.places[None]).transpose(2, 0, 1))
    assert to_places.min() < 0.3
    np.testing.assert_array_equal(newcomer.waypoints[-1], newcomer.position)


def test_without_a_point_they_come_near_the_chair(floor, world):
    for seed in range(20):
        newcomer = new_pedestrian(floor, world.truth, None, chance(seed))
        assert 0.5 < np.hypot(*(newcomer.position - world.truth.pose[:2])) <= 7.0


@pytest.mark.parametrize("point", [(-50.0, 8.0), (1e6, 1e6), (40.9, 25.9)])
def test_where_nobody_can_stand_nobody_comes(floor, world, point):
    with pytest.raises(NoFreeSpace, match="No free space"):
        new_pedestrian(floor, world.truth, np.array(point), chance())


def test_nobody_is_put_on_the_chair(floor, world):
    newcomer = new_pedestrian(floor, world.truth, world.truth.pose[:2].copy(), chance())
    world.spawn(newcomer)
    assert world.truth.gap_people[-1] > 0.1


def test_a_crowd_has_an_end(floor, world, monkeypatch):
    monkeypatch.setattr(simulated, "MAX_PEOPLE", len(world.truth.crowd.radius) + 1)
    world.spawn(new_pedestrian(floor, world.truth, None, chance()))
    with pytest.raises(NoFreeSpace, match="No more than"):
        new_pedestrian(floor, world.truth, None, chance(1))


@pytest.mark.parametrize("seed", range(4))
def test_who_walks_into_the_way_crosses_it_ahead_of_the_chair(ride_setup, floor, seed):
    world = World(ride_setup.world, ride_setup.seed)
    newcomer = crossing_pedestrian(floor, world.truth, ride_setup.route.points, chance(seed))
    way = np.vstack([newcomer.position, newcomer.waypoints])
    route = np.ascontiguousarray(ride_setup.route.points)
    pieces = np.concatenate([np.linspace(a, b, 50) for a, b in itertools.pairwise(way)])
    off = np.array([nearest_on_polyline(route, x, y)[1] for x, y in pieces])
    meeting = pieces[off < 0.2]
    assert len(meeting)
    away = np.hypot(*(meeting - world.truth.pose[:2]).T)
    assert away.min() < 4.5
    # walls stay standing about their way
    assert (distance_field(world.grid).at(pieces) > 0.25).all()


def test_the_same_chance_adds_the_same_people(ride_setup, floor, world):
    for seed in range(3):
        twice = [
            (
                new_pedestrian(floor, world.truth, None, rng),
                crossing_pedestrian(floor, world.truth, np.empty((0, 2)), rng),
            )
            for rng in (chance(seed), chance(seed))
        ]
        assert identical(*twice)


def test_every_door_of_the_floor_is_told_and_can_be_shut(ride_setup, world):
    doors = floor_model(ride_setup.scenario, ride_setup.seed).scene.doors
    assert [door.id for door in doors] == list(range(len(doors)))
    shut = [world.set_door(door.id, shut=True) for door in doors]
    world.advance(STAY)
    assert sum(shut) >= len(doors) - 2  # somebody may stand in one
    for door, is_shut in zip(doors, shut, strict=True):
        middle = (np.array(door.a) + np.array(door.b)) / 2.0
        assert world.grid.occupied()[tuple(world.grid.cells(middle))] == is_shut
