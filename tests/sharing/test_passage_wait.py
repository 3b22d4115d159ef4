"""Waiting before a narrow passage for people who come through it."""

import math

import numpy as np
import pytest

from cohelm.messages import Observation
from cohelm.robots import load_robot
from cohelm.sharing.affordances import NarrowPassage
from cohelm.sharing.passage_wait import STAND_OFF, Surroundings, waits_before
from cohelm.testing.scenes import open_floor

CHAIR = load_robot("quantum_q6_edge")
FRONT = float(CHAIR.outline[:, 0].max())
SPEED = 0.45


def passage(turn=0.0):
    return NarrowPassage(x=0.0, y=0.0, axis=turn, width=0.8)


def about(walking=(), standing=()):
    return Surroundings(
        walls=open_floor(),
        walking=np.array(walking, dtype=float).reshape(-1, 4),
        standing=np.array(standing, dtype=float).reshape(-1, 3),
    )


def wait(gap, people, *, now=0.0, speed=SPEED, memory=None, found=True, turn=0.0, heading=0.0):
    cos, sin = math.cos(turn), math.sin(turn)
    before = -(gap + FRONT)
    pose = np.array([before * cos, before * sin, turn + heading])
    where = passage(turn) if found else None
    seen = Observation(
        time=now,
        pose=pose,
        pose_time=now,
        twist=np.array([speed, 0.0, 0.0]),
        twist_time=now,
    )
    return waits_before(seen, SPEED, where, people, CHAIR, memory)


COMING = about(walking=[(2.0, 0.3, -0.8, 0.0)])


def test_the_chair_goes_on_to_its_place_and_stops_there():
    far, near = wait(2.0, COMING), wait(STAND_OFF, COMING)
    assert far is not None
    assert not far.stands
    assert near is not None
    assert near.stands


def test_a_chair_that_can_brake_in_time_stops_before_its_place():
    braking = SPEED**2 / (2.0 * CHAIR.max_deceleration)
    assert wait(STAND_OFF + braking, COMING).stands
    assert not wait(STAND_OFF + braking, COMING, speed=0.0).stands


@pytest.mark.parametrize(
    "people",
    [
        about(),
        about(walking=[(2.0, 0.0, 0.8, 0.0)]),  # goes away
        about(walking=[(2.0, 0.0, 0.0, 0.8)]),  # goes across
        about(walking=[(-0.9, 0.0, 0.8, 0.0)]),  # goes before the chair
        about(standing=[(1.0, 0.0, 0.25)]),
        about(walking=[(9.0, 0.0, -0.8, 0.0)]),  # too far away
    ],
)
def test_nobody_else_is_waited_for(people):
    assert wait(1.0, people) is None


def test_who_is_through_first_goes_first():
    # 0.1 m before the passage the chair is through in 3 s, and a slow person comes in 13 s
    assert wait(0.1, about(walking=[(3.9, 0.0, -0.3, 0.0)])) is None
    assert wait(0.1, about(walking=[(0.8, 0.0, -0.3, 0.0)])) is not None


def test_a_chair_in_the_passage_goes_on():
    assert wait(-0.1, COMING) is None


def test_it_waits_on_for_a_moment_and_longer_while_somebody_is_in_the_passage():
    seen = wait(STAND_OFF, COMING)
    inside = about(standing=[(0.2, 0.0, 0.25)])
    # people in the passage hide that it leads on
    assert wait(STAND_OFF, about(), now=1.0, memory=seen, found=False).stands
    assert wait(STAND_OFF, about(), now=6.0, memory=seen, found=False) is None
    assert wait(STAND_OFF, inside, now=10.0, memory=seen, found=False).stands
    assert wait(STAND_OFF, inside, now=16.0, memory=seen, found=False) is None


def test_a_chair_that_turns_away_waits_for_nobody():
    seen = wait(STAND_OFF, COMING)
    assert wait(STAND_OFF, COMING, now=0.1, memory=seen, found=False, heading=1.0) is None


@pytest.mark.parametrize("turn", [0.7, -2.4])
def test_waiting_does_not_depend_on_the_frame(turn):
    cos, sin = math.cos(turn), math.sin(turn)
    R = np.array([[cos, -sin], [sin, cos]])
    row = COMING.walking[0]
    turned = about(walking=[np.concatenate([R @ row[:2], R @ row[2:]])])
    for gap in (0.5, 1.0, 1.5):
        assert wait(gap, turned, turn=turn).stands == wait(gap, COMING).stands
