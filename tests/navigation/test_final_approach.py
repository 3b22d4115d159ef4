"""The last metre: the goal is met, not overshot, and not taken from a person."""

import math

import numpy as np
import pytest

from cohelm.messages import People
from cohelm.navigation.final_approach import approach_limit, final_approach, path_up_to
from cohelm.navigation.recovery.context import waiting_place
from cohelm.robots import load_robot
from cohelm.testing.scenes import open_floor, room, walkers, walls_of

from .scenes import Straight

CHAIR = load_robot("quantum_q6_edge")


class Ends:
    """What a path needs."""

    start, goal, wishes = np.array([2.0, 4.0]), np.array([9.0, 4.0]), ()


PATH = Straight().plan(Ends())
"""Of 7 m along y = 4."""


@pytest.mark.parametrize(
    ("remaining", "speed", "limit"),
    [
        (1.0, 0.8, math.inf),  # 0.8 m/s stops in 0.53 m
        (0.3, 0.8, math.sqrt(0.15**2 + 2.0 * 0.6 * (0.3 - 0.15 * 0.8))),  # 0.15 s late
        (0.3, 0.5, math.inf),
        (0.0, 0.6, 0.15),
        (0.0, 0.0, 0.15),  # at the end it stays slow
    ],
)
def test_a_chair_too_fast_for_its_goal_is_limited(remaining, speed, limit):
    assert approach_limit(remaining, np.array([speed, 0.0, 0.0]), 0.6) == pytest.approx(limit)


def test_beside_the_path_the_chair_heads_for_the_goal_itself():
    line = final_approach(PATH, 6.4, np.array([8.4, 4.3]), open_floor(), CHAIR)
    assert line.points[0].tolist() == [8.4, 4.3]
    assert line.points[-1] == pytest.approx([9.0, 4.0])
    assert line.length == pytest.approx(math.hypot(0.6, 0.3))
    beyond = final_approach(PATH, 7.0, np.array([9.1, 4.2]), open_floor(), CHAIR)
    assert beyond.points[-1] == pytest.approx([9.0, 4.0])


def test_on_the_path_far_from_the_goal_or_behind_a_wall_the_path_is_followed():
    assert final_approach(PATH, 6.4, np.array([8.4, 4.05]), open_floor(), CHAIR) is None
    assert final_approach(PATH, 5.0, np.array([7.0, 4.3]), open_floor(), CHAIR) is None
    walls = walls_of(room(boxes=[(8.6, 4.1, 8.8, 4.3)]))
    assert final_approach(PATH, 6.4, np.array([8.4, 4.3]), walls, CHAIR) is None


def test_a_path_is_cut_where_the_chair_waits():
    cut = path_up_to(PATH, 5.5)
    assert cut.points[-1] == pytest.approx([7.5, 4.0])
    assert cut.length == pytest.approx(5.5)


def place(people, progress=5.0, *, waits=False):
    return waiting_place(
        PATH, progress, people, CHAIR, distance=0.45, standing_speed=0.3, waits=waits
    )


def test_a_person_at_the_goal_is_waited_for_outside_their_space():
    people = walkers([(9.0, 4.0, 0.0, 0.0)])
    at = place(people)
    # The front is 0.65 m ahead of the axle, and the capsule about it up to 0.15 m more.
    gap = 9.0 - float(people.radius[0]) - (2.0 + at + 0.65)
    assert 0.45 <= gap <= 0.45 + 0.15 + 0.11
    assert place(people, 6.5) == 6.5  # who is nearer already stays there


@pytest.mark.parametrize(
    "person", [(9.0, 4.0, 0.6, 0.0), (9.0, 5.2, 0.0, 0.0), (7.0, 4.0, 0.0, 0.0)]
)
def test_a_person_who_walks_or_stands_elsewhere_leaves_the_goal_free(person):
    assert place(walkers([person])) is None


def test_from_far_away_and_without_people_nothing_is_waited_for():
    assert place(walkers([(9.0, 4.0, 0.0, 0.0)]), 3.0) is None
    assert place(People.empty(0.0)) is None


def test_a_person_who_only_stepped_aside_a_little_is_still_waited_for():
    side = float(CHAIR.capsule[4]) + float(walkers([(0.0,) * 4]).radius[0])
    people = walkers([(9.0, 4.0 + side + 0.07, 0.0, 0.0)])  # 7 cm beside the chair at its goal
    assert place(people) is None
    assert place(people, waits=True) is not None
