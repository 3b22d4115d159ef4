"""The view of a rider, and the reaction of an ideal one."""

from dataclasses import replace

import numpy as np
import pytest
from tests.simulation.riders.rider_views import view

from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision
from cohelm.plugins import build
from cohelm.robots import move
from cohelm.simulation import World
from cohelm.simulation.contact import gap_to_people, gap_to_walls
from cohelm.simulation.world import DIRECTIONS, OBSTACLE_RANGE, view_from

POSE = np.array([2.0, 5.0, 0.0])
WALL = (5.0, 3.0, 5.2, 7.0)


def test_whoever_stands_behind_a_wall_is_not_seen(make_grid, make_crowd):
    crowd = make_crowd([[4.0, 5.0], [7.0, 5.0], [7.0, 9.0]], np.zeros((3, 1, 2)))
    people, _ = view_from(make_grid(boxes=(WALL,)), POSE, crowd)
    np.testing.assert_allclose(people[:, :2], [[2.0, 0.0], [5.0, 4.0]])
    people, _ = view_from(make_grid(), POSE, crowd)
    assert len(people) == 3


def test_nobody_behind_the_back_or_far_away_is_seen(make_grid, make_crowd):
    crowd = make_crowd([[1.0, 5.0], [2.0, 6.0], [11.9, 5.0]], np.zeros((3, 1, 2)))
    people, _ = view_from(make_grid(), POSE, crowd)
    np.testing.assert_allclose(people[:, :2], [[0.0, 1.0], [9.9, 0.0]])
    people, _ = view_from(make_grid(width=30.0), np.array([1.0, 5.0, 0.0]), crowd)
    np.testing.assert_allclose(people[:, :2], [[0.0, 0.0], [1.0, 1.0]])  # 10.9 m are too far


def test_the_floor_is_free_up_to_the_wall(make_grid, make_crowd):
    _, free = view_from(make_grid(boxes=(WALL,)), POSE, make_crowd([], []))
    ahead = np.abs(DIRECTIONS) < np.arctan2(1.9, 3.2)
    np.testing.assert_allclose(free[ahead], 3.0 / np.cos(DIRECTIONS[ahead]), atol=1e-9)
    assert np.isinf(free).any()
    assert free[np.isfinite(free)].max() <= OBSTACLE_RANGE


def test_what_is_seen_turns_with_the_chair(make_grid, make_crowd):
    crowd = make_crowd([[2.0, 7.0]], np.zeros((1, 1, 2)), velocity=np.array([[1.0, 0.0]]))
    people, _ = view_from(make_grid(), np.array([2.0, 5.0, np.pi / 2.0]), crowd)
    np.testing.assert_allclose(people, [[2.0, 0.0, 0.0, -1.0, 0.25]], atol=1e-12)


def steered(**seen):
    seen = view(0.0, goal=np.array([9.0, 0.0]), route=np.empty((0, 2)), **seen)
    act = build("riders", "ideal").act(seen, None, np.random.default_rng(0))
    return act.command.deflection


def test_an_ideal_rider_steers_round_who_stands_in_the_way_and_stops_for_whom_they_cannot():
    beside = np.array([[2.0, -0.1, 0.0, 0.0, 0.25]])
    free = np.full(len(DIRECTIONS), np.inf)
    forward, left = steered(people=beside, bearings=DIRECTIONS, free=free)
    assert forward > 0.3
    assert left > 0.1
    close = np.array([[1.0, y, 0.0, 0.0, 0.4] for y in np.arange(-4.0, 4.1, 0.4)])
    forward, _ = steered(people=close, bearings=DIRECTIONS, free=free)
    np.testing.assert_allclose(forward, 0.0, atol=0.02)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_ideal_rider_passes_a_box_on_the_freer_side(side):
    y = np.tan(DIRECTIONS) * 1.5
    box = (np.abs(DIRECTIONS) < 1.2) & (np.abs(y + 0.25 * side) < 0.4)
    free = np.where(box, 1.5 / np.cos(DIRECTIONS), np.inf)
    assert steered(bearings=DIRECTIONS, free=free)[1] * side > 0.1


def fine(boxes):
    """Boxes (x0, y0, x1, y1) to the centimetre."""
    data = np.zeros((1000, 1200), dtype=np.int8)
    for box in boxes:
        x0, y0, x1, y1 = (round(100.0 * b) for b in box)
        data[y0:y1, x0:x1] = 100
    return OccupancyGrid(data=data, resolution=0.01, X_MG=np.zeros(3))


def driven(chair, grid, pose, crowd, *, seconds=40.0, goal=(8.0, 5.0)):
    """A chair in an ideal rider's hand alone, along y = 5: (where it ends, the least gaps)."""
    rider, memory, pose, twist = build("riders", "ideal"), None, np.array(pose), np.zeros(3)
    up, down = np.array([0.8, 0.0, 2.5]), np.array([1.0, 0.0, 2.5])
    to_wall, to_person = np.inf, np.inf
    goal = np.array(goal)
    for k in range(round(seconds / 0.05)):
        people, free = view_from(grid, pose, crowd)
        told = view(0.05 * k, pose, route=np.array([[pose[0], 5.0], goal]), goal=goal)
        told = replace(told, twist=twist, people=people, bearings=DIRECTIONS, free=free)
        act = rider.act(replace(told, outline=chair.outline), memory, np.random.default_rng(0))
        memory, (forward, left) = act.memory, act.command.deflection
        wanted = np.array([0.8 * forward, 0.0, 1.2 * left])
        twist = twist + np.clip(wanted - twist, -0.05 * down, 0.05 * up)
        pose = move(pose, twist, 0.05)
        crowd = replace(crowd, position=crowd.position + 0.05 * crowd.velocity)
        to_wall = min(to_wall, gap_to_walls(chair.outline, pose, grid))
        gaps = gap_to_people(chair.outline, pose, crowd.position, crowd.radius)
        to_person = min(to_person, gaps.min(initial=np.inf))
        if not (forward or left) and np.hypot(*(pose[:2] - goal)) < 0.2:
            break
    return pose, to_wall, to_person


@pytest.mark.parametrize("offset", [0.0, -0.4])
@pytest.mark.parametrize("gap", [0.78, 0.8, 0.9])
def test_an_ideal_rider_passes_a_gap_little_wider_than_the_chair(make_crowd, chair, gap, offset):
    """The chair is 0.61 m wide; through a wall, and beside a post to which the route leads."""
    half = gap / 2.0
    wall = ((4.0, 1.0, 4.2, 5.0 - half), (4.0, 5.0 + half, 4.2, 9.0))
    aside = 0.1 + gap
    post = ((4.0, 4.9, 4.2, 5.1), (0.0, 4.9 - aside, 12.0, 5.0 - aside))
    post += ((0.0, 5.0 + aside, 12.0, 5.1 + aside),)
    for boxes, start in ((wall, offset), (post, offset / 4.0)):
        pose, to_wall, _ = driven(chair, fine(boxes), (1.0, 5.0 + start, 0.0), make_crowd([], []))
        assert to_wall > 0.0
        assert np.hypot(pose[0] - 8.0, pose[1] - 5.0) < 0.2


@pytest.mark.parametrize(
    ("start", "velocity"),
    [
        ((4.5, 5.0), (0.0, 0.0)),
        ((7.5, 5.0), (-0.8, 0.0)),
        ((4.5, 2.9), (0.0, 0.6)),
        ((4.5, 5.0), (0.3, 0.0)),
    ],
)
def test_an_ideal_rider_touches_nobody_who_goes_on_as_they_do(
    make_grid, make_crowd, chair, start, velocity
):
    crowd = make_crowd([start], np.zeros((1, 1, 2)), velocity=np.array([velocity]))
    pose, _, to_person = driven(chair, make_grid(), (1.0, 5.0, 0.0), crowd)
    assert to_person > 0.05
    assert np.hypot(pose[0] - 8.0, pose[1] - 5.0) < 0.2


def test_an_ideal_rider_waits_before_a_gap_that_is_too_narrow(make_grid, make_crowd, chair):
    wall = ((4.0, 0.0, 4.2, 4.72), (4.0, 5.28, 4.2, 10.0))  # 0.56 m
    pose, to_wall, _ = driven(
        chair, make_grid(boxes=wall), (1.0, 5.0, 0.0), make_crowd([], []), seconds=12.0
    )
    assert to_wall > 0.0
    assert pose[0] < 4.0


def test_a_door_that_opens_is_not_remembered_as_shut(make_grid, make_crowd, chair):
    """What ought to be in sight and is not any more is forgotten after two seconds."""
    rider, memory, pose = build("riders", "ideal"), None, np.array([3.0, 5.0, 0.0])
    shut, nobody = make_grid(boxes=((4.0, 0.0, 4.2, 10.0),)), make_crowd([], [])
    pushes = []
    for k in range(100):
        people, free = view_from(shut if k < 40 else make_grid(), pose, nobody)
        told = view(0.05 * k, pose, route=np.array([[1.0, 5.0], [9.0, 5.0]]))
        told = replace(told, people=people, bearings=DIRECTIONS, free=free, outline=chair.outline)
        act = rider.act(told, memory, np.random.default_rng(0))
        memory = act.memory
        pushes.append(act.command.deflection[0])
    assert max(pushes[:40]) == 0.0
    assert min(pushes[85:]) > 0.3


def test_one_who_does_not_look_sees_nobody():
    seen = view(0.0, people=np.array([[1.0, 0.0, 0.0, 0.0, 0.3]]))
    act = build("riders", {"use": "ideal", "avoids_obstacles": False}).act(seen, None, None)
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
