"""Pedestrians who enter later do not change the others, with every pedestrian model."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm import plugins
from cohelm.arrays import identical
from cohelm.messages import Decision
from cohelm.simulation import NewPedestrian, World, prepare_crowd
from cohelm.simulation.world import with_pedestrian

STAY = Decision(twist=np.zeros(3))
MODELS = plugins.names("pedestrian_models")


@pytest.fixture
def newcomer():
    """Somebody who comes in at (9, 2) and walks along x = 9."""
    return NewPedestrian(position=np.array([9.0, 2.0]), waypoints=np.array([[9.0, 8.0]]), speed=1.0)


@pytest.fixture
def peopled(make_setup, make_crowd):
    """Two people with a model of their own, far from each other and from the chair."""

    def make(model, **changes):
        walks = plugins.build("pedestrian_models", model)
        crowd = make_crowd(
            [[5.0, 1.0], [10.0, 9.0]], [[[5.0, 9.0]], [[2.0, 9.0]]], sees_robot=[True, False]
        )
        return make_setup(crowd=prepare_crowd(walks, crowd), pedestrian_model=walks, **changes)

    return make


@pytest.mark.parametrize("model", MODELS)
def test_with_every_model_they_walk_to_where_they_wanted(peopled, newcomer, model):
    world = World(peopled(model), 0)
    for k in range(180):
        if k == 20:
            assert world.spawn(newcomer) == 2
        world.advance(STAY)
    crowd = world.truth.crowd
    assert len(crowd.radius) == 3
    assert np.hypot(*(crowd.position[2] - [9.0, 8.0])) < 0.4
    assert np.isfinite(crowd.position[crowd.there]).all()


@pytest.mark.parametrize("model", MODELS)
def test_the_same_newcomer_at_the_same_time_is_the_same_ride(peopled, newcomer, model):
    setup, rides = peopled(model), []
    for _ in range(2):
        world = World(setup, 3)
        for k in range(40):
            if k == 10:
                world.spawn(newcomer)
            world.advance(STAY)
        rides.append((world.truth, world.observe()))
    assert identical(*rides)


def test_until_they_come_the_ride_is_as_without_them(peopled, newcomer):
    one, two = World(peopled("orca"), 5), World(peopled("orca"), 5)
    for _ in range(10):
        one.advance(STAY)
        two.advance(STAY)
    before = two.observe()
    two.spawn(newcomer)
    assert identical(two.observe(), before)  # sensors have not swept since
    assert identical(one.observe(), before)
    np.testing.assert_array_equal(two.truth.crowd.position[:2], one.truth.crowd.position)


def test_chair_and_sensors_have_the_chance_that_they_had(peopled, newcomer):
    """Chance has a generator for each purpose: the localiser errs as it would without them."""
    one, two = World(peopled("orca"), 5), World(peopled("orca"), 5)
    two.spawn(newcomer)
    for _ in range(20):
        one.advance(STAY)
        two.advance(STAY)
        np.testing.assert_array_equal(one.observe().pose, two.observe().pose)
        np.testing.assert_array_equal(one.observe().twist, two.observe().twist)


def test_the_referee_and_the_laser_see_them(make_setup, make_crowd):
    world = World(make_setup(), 0)
    stands = NewPedestrian(position=np.array([4.0, 5.0]), waypoints=np.empty((0, 2)))
    world.spawn(stands)
    outline = world.setup.robot.outline
    front = 2.0 + outline[:, 0].max()
    assert world.truth.gap_people[0] == pytest.approx(4.0 - 0.25 - front, abs=1e-9)
    for _ in range(4):
        world.advance(STAY)
    scan = world.observe().scans[-1]
    assert np.nanmin(scan.ranges) < 2.0 - 0.25 + 0.6
    np.testing.assert_array_equal(world.truth.crowd.position[0], [4.0, 5.0])


def test_who_is_touched_is_told_for_newcomers_too(make_setup):
    world = World(make_setup(), 0)
    at = np.array([4.0, 5.0])
    world.spawn(NewPedestrian(position=at, waypoints=np.empty((0, 2)), sees_robot=False))
    touched = np.zeros(1, dtype=bool)
    for _ in range(60):
        world.advance(Decision(twist=np.array([1.0, 0.0, 0.0])))
        touched |= world.truth.hit_moving
    assert touched.all()


def test_records_groups_and_presence_grow_with_the_crowd(make_crowd, newcomer):
    crowd = make_crowd(
        [[1.0, 1.0]],
        [[[2.0, 2.0], [3.0, 3.0]]],
        group=np.array([4]),
        present=np.array([False]),
        memory=np.array([[1.0, 2.0]]),
    )
    more = with_pedestrian(crowd, newcomer)
    np.testing.assert_array_equal(more.group, [4, -1])
    np.testing.assert_array_equal(more.present, [False, True])
    np.testing.assert_array_equal(more.memory, [[1.0, 2.0], [np.nan, np.nan]])
    np.testing.assert_array_equal(more.waypoints[0], crowd.waypoints[0])
    np.testing.assert_array_equal(more.waypoints[1], [[9.0, 8.0], [np.nan, np.nan]])
    plain = with_pedestrian(make_crowd([], []), replace(newcomer, waypoints=np.empty((0, 2))))
    assert plain.group is plain.present is plain.memory is None
    assert plain.waypoints.shape == (1, 1, 2)
