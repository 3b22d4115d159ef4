"""Rear clearance: who is behind the chair, standing or walking."""

import numpy as np
import pytest

from cohelm.messages import Observation
from cohelm.navigation.recovery.rear_clearance import RearScene, extend_trail, rear_clearance
from cohelm.robots import load_robot
from cohelm.testing.scenes import BODY, open_floor, walkers

CHAIR = load_robot("quantum_q6_edge")
LOW, HIGH = CHAIR.outline.min(axis=0), CHAIR.outline.max(axis=0)


def clearance(*people):
    """Clearance of a chair at the origin that has just come along the x axis, m."""
    trail = None
    for k, x in enumerate(np.arange(-2.0, 0.01, 0.1)):
        trail = extend_trail(trail, np.array([x, 0.0, 0.0]), 0.1 * k, 8.0)
    scene = RearScene((), open_floor(), walkers(people))
    seen = Observation(time=2.0, pose=np.zeros(3), twist=np.zeros(3), pose_time=2.0, twist_time=2.0)
    return rear_clearance(trail, CHAIR, seen, scene, curvature=0.0, limit=0.4)[0]


def beside(gap, *velocity):
    return (LOW[0], HIGH[1] + BODY + gap, *velocity)


def behind(gap, *velocity):
    return (LOW[0] - BODY - gap, 0.0, *velocity)


def test_a_chair_that_came_that_way_may_back_up():
    assert clearance() == pytest.approx(0.4)


def test_somebody_who_stands_near_the_rear_leaves_more_room_than_somebody_who_walks():
    """One who stands waits; one who walks may be behind the chair in a second."""
    assert clearance(beside(0.3, 0.0, 0.0)) == pytest.approx(0.4)
    assert clearance(beside(0.3, 0.3, 0.0)) == 0.0
    assert clearance(behind(1.0, 0.0, 0.0)) == pytest.approx(0.4)
    assert clearance(behind(1.0, -0.3, 0.0)) == 0.0


def test_nobody_stands_within_half_a_metre_behind_the_backed_up_chair():
    assert clearance(behind(0.85, 0.0, 0.0)) == 0.0
    assert clearance(beside(0.15, 0.0, 0.0)) == 0.0
