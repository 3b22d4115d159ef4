"""Time of the last contact: whom it counts, and that a stop of the health monitor keeps it."""

import dataclasses

import numpy as np
import pytest

from cohelm.messages import Observation, Reason
from cohelm.navigation import Navigator
from cohelm.navigation.world_model import update_last_contact
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing.scenes import local_problem, walkers

ROBOT = local_problem(steps=8, step=0.16).robot
FRONT = float(ROBOT.capsule[2] + ROBOT.capsule[4]) + 0.25
"""Position of somebody of radius 0.25 m who touches the front of the chair, m."""
BEHIND = float(ROBOT.capsule[0] - ROBOT.capsule[4]) - 0.25


def contact(x, speed, *, before=-np.inf, driving=0.0):
    """Last contact at 7 s of a chair at the origin, with somebody on its axis."""
    seen = Observation(
        time=7.0,
        pose_time=7.0,
        twist_time=7.0,
        pose=np.zeros(3),
        twist=np.array([driving, 0.0, 0.0]),
    )
    return update_last_contact(before, ROBOT, seen, walkers([[x, 0.0, speed, 0.0]], time=7.0))


@pytest.mark.parametrize(
    ("x", "speed", "driving", "expected"),
    [
        (FRONT + 0.01, -0.4, 0.0, 7.0),  # walks against the chair
        (FRONT + 0.3, -0.4, 0.0, 3.0),  # has not reached it
        (FRONT + 0.01, 0.0, 0.0, 3.0),  # stands beside it
        (FRONT - 0.15, -0.4, 0.0, 9.0),  # is soon hidden, and comes out again within 2 s
        (BEHIND - 0.01, 0.6, 0.5, 3.0),  # walks behind a chair that drives on
        (BEHIND - 0.01, 0.6, 0.0, 7.0),  # walks into the back of one that stands
    ],
)
def test_the_last_contact_is_with_somebody_who_walks_into_the_chair(x, speed, driving, expected):
    assert contact(x, speed, before=3.0, driving=driving) == pytest.approx(expected)


def test_a_hidden_person_is_not_forgotten_while_they_can_still_be_inside():
    assert contact(FRONT + 3.0, 0.4, before=9.0) == pytest.approx(9.0)


def test_a_stop_of_the_health_monitor_keeps_the_contact():
    """Half the view is hidden for 2 s, as by people who press against the scanner."""
    stage = build_scenario(load_scenario("crossing"), 3)
    world, navigator, tick = World(stage.world, 3), Navigator(stage.navigator), None
    began = 1.5
    while world.truth.time < began + 2.0:
        now, seen = world.truth.time, world.observe()
        if now >= began:
            seen = dataclasses.replace(seen, scans=tuple(_half_hidden(s) for s in seen.scans))
        if tick is not None and np.isneginf(tick.memory.last_contact) and now > began + 0.5:
            # a contact of which the rest of the ride only has the memory
            kept = dataclasses.replace(tick.memory, last_contact=now)
            tick, noted = dataclasses.replace(tick, memory=kept), now
        tick = navigator.step(seen, stage.request, tick)
        world.advance(tick.decision)
    assert tick.decision.reason is Reason.SCAN_IMPLAUSIBLE
    assert tick.memory.last_contact == pytest.approx(noted)


def _half_hidden(scan):
    hidden = np.arange(len(scan.ranges)) % 4 < 2
    return dataclasses.replace(scan, ranges=np.where(hidden, 0.0, scan.ranges))
