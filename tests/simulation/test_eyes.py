"""What a rider sees, and what an ideal one makes of it."""

import numpy as np
import pytest
from tests.simulation.hands import view

from cohelm.messages import Decision
from cohelm.plugins import build
from cohelm.simulation import World
from cohelm.simulation.eyes import GLANCES, NEAR, look

POSE = np.array([2.0, 5.0, 0.0])
WALL = (5.0, 3.0, 5.2, 7.0)


def test_whoever_stands_behind_a_wall_is_not_seen(make_grid, make_crowd):
    crowd = make_crowd([[4.0, 5.0], [7.0, 5.0], [7.0, 9.0]], np.zeros((3, 1, 2)))
    people, _ = look(make_grid(boxes=(WALL,)), POSE, crowd)
    np.testing.assert_allclose(people[:, :2], [[2.0, 0.0], [5.0, 4.0]])
    people, _ = look(make_grid(), POSE, crowd)
    assert len(people) == 3


def test_nobody_behind_the_back_or_far_away_is_seen(make_grid, make_crowd):
    crowd = make_crowd([[1.0, 5.0], [2.0, 6.0], [11.9, 5.0]], np.zeros((3, 1, 2)))
    people, _ = look(make_grid(), POSE, crowd)
    np.testing.assert_allclose(people[:, :2], [[0.0, 1.0], [9.9, 0.0]])
    people, _ = look(make_grid(width=30.0), np.array([1.0, 5.0, 0.0]), crowd)
    np.testing.assert_allclose(people[:, :2], [[0.0, 0.0], [1.0, 1.0]])  # 10.9 m are too far


def test_the_floor_is_free_up_to_the_wall(make_grid, make_crowd):
    _, free = look(make_grid(boxes=(WALL,)), POSE, make_crowd([], []))
    ahead = np.abs(GLANCES) < np.arctan2(1.9, 3.2)
    np.testing.assert_allclose(free[ahead], 3.0 / np.cos(GLANCES[ahead]), atol=1e-9)
    assert np.isinf(free).any()
    assert free[np.isfinite(free)].max() <= NEAR


def test_what_is_seen_turns_with_the_chair(make_grid, make_crowd):
    crowd = make_crowd([[2.0, 7.0]], np.zeros((1, 1, 2)), velocity=np.array([[1.0, 0.0]]))
    people, _ = look(make_grid(), np.array([2.0, 5.0, np.pi / 2.0]), crowd)
    np.testing.assert_allclose(people, [[2.0, 0.0, 0.0, -1.0, 0.25]], atol=1e-12)


def steered(**seen):
    seen = view(0.0, goal=np.array([9.0, 0.0]), route=np.empty((0, 2)), **seen)
    act = build("riders", "ideal").act(seen, None, np.random.default_rng(0))
    return act.command.deflection


def test_an_ideal_rider_steers_round_who_stands_in_the_way_and_stops_for_whom_they_cannot():
    beside = np.array([[2.0, -0.1, 0.0, 0.0, 0.25]])
    free = np.full(len(GLANCES), np.inf)
    forward, left = steered(people=beside, bearings=GLANCES, free=free)
    assert forward > 0.3
    assert left > 0.1
    close = np.array([[1.0, y, 0.0, 0.0, 0.4] for y in np.arange(-4.0, 4.1, 0.4)])
    forward, _ = steered(people=close, bearings=GLANCES, free=free)
    np.testing.assert_allclose(forward, 0.0, atol=0.02)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_ideal_rider_passes_a_box_on_the_freer_side(side):
    y = np.tan(GLANCES) * 1.5
    box = (np.abs(GLANCES) < 1.2) & (np.abs(y + 0.25 * side) < 0.4)
    free = np.where(box, 1.5 / np.cos(GLANCES), np.inf)
    assert steered(bearings=GLANCES, free=free)[1] * side > 0.1


def test_one_who_does_not_look_sees_nobody():
    seen = view(0.0, people=np.array([[1.0, 0.0, 0.0, 0.0, 0.3]]))
    act = build("riders", {"use": "ideal", "looks": False}).act(seen, None, None)
    np.testing.assert_array_equal(act.command.deflection, [0.7, 0.0])


def test_a_world_hands_the_rider_memory_and_view(make_setup):
    """A late hand in a world: centred for 0.3 s, then what an ideal one would have done."""
    first = []
    for rider in ({"use": "delayed", "delay": 0.3}, "ideal"):
        world, told = World(make_setup(rider=build("riders", rider)), seed=0), []
        for _ in range(10):
            told.append(world.observe().rider.deflection)
            world.advance(Decision(twist=np.zeros(3)))
        first.append(np.array(told))
    np.testing.assert_array_equal(first[0][:6], 0.0)
    np.testing.assert_array_equal(first[0][6:], first[1][:4])
