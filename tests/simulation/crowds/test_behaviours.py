"""Aggressive, distracted and inattentive people, and people who turn back."""

import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.maps import OccupancyGrid
from cohelm.simulation import (
    Aggressive,
    Distracted,
    Inattentive,
    Orca,
    TurningBack,
    prepare_crowd,
)
from cohelm.simulation.crowds.motion import opposite_targets

ROBOT = np.array([5.0, 0.1])
RADIUS, BODY, DT = 0.5, 0.25, 0.05


def walk(model, crowd, scene, seconds):
    rng = np.random.default_rng(0)
    crowds = [prepare_crowd(model, crowd)]
    for k in range(round(seconds / DT)):
        now = dataclasses.replace(scene, time=k * DT)
        crowds.append(model.step(crowds[-1], now, DT, rng))
    return crowds


@pytest.fixture
def scene(make_scene):
    return make_scene(robot_position=ROBOT)


def one(make_crowd, *, sees=True, to=((0.0, 0.0), (10.0, 0.0))):
    return make_crowd([[0.0, 0.0]], [to], sees_robot=np.array([sees]), target=np.array([1]))


def positions(crowds):
    return np.array([c.position[0] for c in crowds])


@pytest.mark.parametrize("inner", ["orca", "social_force"])
def test_the_aggressive_walk_as_who_does_not_see_the_chair(make_crowd, scene, inner):
    model = Aggressive(Aggressive.Parameters(walk=inner))
    plain = Aggressive(Aggressive.Parameters(walk=inner, only=(7,)))  # nobody is number 7
    assert identical(
        positions(walk(model, one(make_crowd), scene, 8.0)),
        positions(walk(plain, one(make_crowd, sees=False), scene, 8.0)),
    )
    seeing = positions(walk(plain, one(make_crowd), scene, 8.0))
    assert np.abs(seeing[:, 1]).max() > 0.3  # who sees it does go round


def test_only_those_who_are_named_are_aggressive(make_crowd):
    crowd = make_crowd(
        np.zeros((3, 2)), np.ones((3, 1, 2)), sees_robot=np.array([True, True, False])
    )
    model = Aggressive(Aggressive.Parameters(only=(1,)))
    assert prepare_crowd(model, crowd).sees_robot.tolist() == [True, False, False]


@pytest.mark.parametrize(("distance", "reaction"), [(1.5, 0.5), (3.0, 0.0), (0.7, 1.0)])
def test_the_inattentive_react_from_their_distance_and_time_on(
    make_crowd, scene, distance, reaction
):
    model = Inattentive(Inattentive.Parameters(distance=distance, reaction_time=reaction))
    late = walk(model, one(make_crowd), scene, 8.0)
    blind = walk(Orca(), one(make_crowd, sees=False), scene, 8.0)
    gap = np.hypot(*(positions(blind) - ROBOT).T) - BODY - RADIUS
    noticed = int(np.argmax(gap <= distance))
    first = noticed + round(reaction / DT)  # the step in which they first may do otherwise
    differs = np.flatnonzero((positions(late) != positions(blind)).any(axis=1))
    assert differs[0] == first + 1
    again = walk_from(Orca(), blind[first], scene, first, 8)
    np.testing.assert_array_equal(positions(late)[first : first + 9], positions(again))


def walk_from(model, crowd, scene, start, steps):
    """Orca with open eyes from a moment on."""
    crowds = [dataclasses.replace(crowd, sees_robot=np.array([True]))]
    rng = np.random.default_rng(0)
    rng.standard_normal(start)  # what was drawn before
    for k in range(start, start + steps):
        now = dataclasses.replace(scene, time=k * DT)
        crowds.append(model.step(crowds[-1], now, DT, rng))
    return crowds


def test_the_distracted_turn_back_once_beside_the_chair_and_within_04_s(make_crowd, make_scene):
    scene = make_scene(robot_position=np.array([5.0, 1.5]))
    crowds = walk(Distracted(), one(make_crowd), scene, 40.0)
    x = positions(crowds)[:, 0]
    gap = np.hypot(*(positions(crowds) - scene.robot_position).T) - BODY - RADIUS
    turn = int(np.argmax(gap <= 1.5))
    assert turn > 0
    velocity = np.array([c.velocity[0, 0] for c in crowds])
    assert velocity[turn] > 0.9  # 1 m/s until then
    assert velocity[turn + round(0.4 / DT)] < -0.9  # 2 m/s of change at 6 m/s² take 0.33 s
    back = turn + int(np.argmin(x[turn:]))
    assert x[back] < 0.6  # within a way-point's reach of where they came from
    assert x[-1] > 9.5  # and then on: they turn once


def test_moods_go_on_top_of_each_other(make_crowd, make_scene):
    crowd = make_crowd(
        [[0.0, 0.0], [0.0, 3.0]], [[[0.0, 0.0], [10.0, 0.0]], [[0.0, 3.0], [10.0, 3.0]]],
        sees_robot=np.ones(2, dtype=bool), target=np.ones(2, dtype=np.int64),
    )  # fmt: skip
    inner = {"use": "distracted", "only": [0]}
    model = Inattentive(Inattentive.Parameters(walk=inner, only=(1,)))
    crowds = walk(model, crowd, make_scene(robot_position=np.array([5.0, 1.5])), 12.0)
    assert crowds[0].memory.shape == crowds[-1].memory.shape == (2, 2)
    assert crowds[0].sees_robot.tolist() == [False, True]
    noticed, turned = crowds[-1].memory.T
    assert np.isfinite(noticed[1])
    assert np.isfinite(turned[0])
    assert np.isnan(noticed[0])
    assert np.isnan(turned[1])


def aisle(make_crowd, trips):
    """Two people in an aisle of their own width, who want to pass each other."""
    starts = [trip[0] for trip in trips]
    n = len(trips)
    return make_crowd(starts, trips, loop=np.ones(n, dtype=bool), target=np.ones(n, dtype=np.int64))


def test_of_two_who_meet_in_an_aisle_one_turns_back(make_crowd, make_scene):
    there, back = (0.0, 0.0), (10.0, 0.0)
    crowd = aisle(make_crowd, ((there, back), (back, there)))
    walls = np.zeros((12, 140), dtype=np.int8)
    walls[:3] = walls[-3:] = 100  # 0.6 m remain between them
    grid = OccupancyGrid(data=walls, resolution=0.1, X_MG=np.array([-2.0, -0.6, 0.0]))
    scene = make_scene(grid=grid, robot_position=np.array([50.0, 50.0]))
    turns = [
        np.ptp([c.target for c in walk(model, crowd, scene, 14.0)], axis=0)
        for model in (Orca(), TurningBack())
    ]
    assert turns[0].tolist() == [0, 0]
    assert sorted(turns[1].tolist()) == [0, 1]


@pytest.mark.parametrize("inner", ["orca", "social_force"])
def test_nobody_turns_back_on_a_free_way(make_crowd, scene, inner):
    trip = ((0.0, 3.0), (4.0, 3.0), (8.0, 3.0), (4.0, 3.0))
    crowd = aisle(make_crowd, (trip,))
    plain, patient = (
        walk(Model(Model.Parameters(walk=inner)), crowd, scene, 20.0)
        for Model in (Aggressive, TurningBack)
    )
    assert identical(positions(plain), positions(patient))


def test_the_way_back_of_a_round_trip_mirrors_the_way_out():
    a, b, c = (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)
    waypoints = np.array([[a, b, c, b], [a, b, c, a]])
    # From a towards b, turned back: to a. From b towards c, turned back: to b on the way back.
    for target, opposite in ((1, 0), (2, 3), (3, 2), (0, 1)):
        found = opposite_targets(waypoints, np.array([target, target]))
        assert found.tolist() == [opposite, -1]  # a round with a corner of its own has no way back
