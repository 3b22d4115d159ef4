"""Rides towards an edge of the floor, and over floor that no sensor saw."""

import math

import numpy as np
import pytest

from cohelm.arrays import replace
from cohelm.evaluation import Outcome, run
from cohelm.evaluation.episode.episode import Course
from cohelm.geometry import transform
from cohelm.messages import Reason
from cohelm.navigation import Navigator
from cohelm.navigation.floor import CREEPING
from cohelm.platforms import open_simulation
from cohelm.scenarios import build_scenario
from cohelm.scenarios.scenario import Scenario

EDGE = 8.0
"""Where the floor changes in the hall, m along x."""
HELPED = ("assisted", "shared", "stop_only", "autonomous")


def towards(level, mode="assisted", *, angle=0.0, robot="quantum_q6_edge_lidar", **changes):
    """A chair on its way to a goal on the other side, 3 m before the edge, at an angle to it."""
    ahead = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    middle = np.array([EDGE, 7.0])
    fields = {
        "name": "edge",
        "floor": "hall",
        "robot": robot,
        "start": [*(middle - 3.0 * ahead), angle],
        "goal": [*(middle + 2.0 * ahead)],
        "mode": mode,
        "rider": {"use": "ideal"},
        "people": {"count": 0},
        "storey": {"levels": [{"at": [11.0, 7.0], "size": [6.0, 14.0], **level}]},
        "profile": {"preferred_speed": 0.8},
        "time_limit": 12,
    }
    return Scenario(**{**fields, **changes})


def beyond(ride):
    """Greatest distance of a wheel beyond the edge during the ride, m."""
    wheels = np.array([transform(pose, ride.robot.wheels)[:, 0].max() for pose in ride.pose])
    return wheels.max() - EDGE


@pytest.mark.parametrize("mode", HELPED)
@pytest.mark.parametrize("angle", [0.0, 50.0])
def test_the_chair_does_not_drive_off_an_edge(mode, angle):
    ride = run(towards({"height": -0.06}, mode, angle=angle), 0)
    assert ride.outcome is not Outcome.FELL
    assert beyond(ride) < 0.0
    # it came near; a chair that steers alone turns away at first sight, and looks for another way
    assert beyond(ride) > (-2.4 if mode == "autonomous" else -0.8)


def test_a_stop_at_an_edge_names_it():
    ride = run(towards({"rise": -1.7, "steps": 10}, "stop_only"), 0)
    assert ride.outcome is not Outcome.FELL
    assert ride.ticks[-1].decision.reason is Reason.EDGE_AHEAD
    assert not ride.twist[-1].any()


@pytest.mark.parametrize("mode", ["shared", "manual"])
def test_an_edge_that_stopped_the_chair_is_crossed_slowly_once_it_is_allowed(mode):
    setup = build_scenario(towards({"height": -0.06}, mode, time_limit=30), 0)
    platform, world = open_simulation(setup)
    course = Course(setup, platform, world, Navigator(setup.navigator))
    stopped = []

    def allow(tick, truth):
        edge = tick.decision.reason is Reason.EDGE_AHEAD and not tick.decision.twist.any()
        # In manual nothing stops it: edges are allowed from the beginning.
        if (edge or mode == "manual") and not stopped:
            stopped.append(tick.observation.time)
            course.setup = replace(setup, request=replace(setup.request, over_edges=True))

    ride = course.run(allow)
    assert stopped
    assert beyond(ride) > 0.0
    assert np.abs(ride.twist[ride.time > stopped[0], 0]).max() <= CREEPING + 0.03
    assert ride.ticks[-1].decision.reason is Reason.EDGES_ALLOWED


def test_manual_can_fall_as_it_can_collide():
    ride = run(towards({"height": -0.3}, "manual"), 0)
    assert ride.outcome is Outcome.FELL


def test_a_planar_scanner_sees_no_edge():
    ride = run(towards({"height": -0.3}, "shared", robot="quantum_q6_edge"), 0)
    assert ride.outcome is Outcome.FELL
    assert ride.ticks[-1].memory.floor is None


def test_a_step_that_the_chair_can_take_holds_nobody():
    ride = run(towards({"height": -0.02}, "shared", time_limit=20), 0)
    assert ride.outcome is Outcome.REACHED


@pytest.mark.parametrize("mode", ["assisted", "autonomous"])
def test_the_chair_creeps_over_floor_that_returns_nothing(mode):
    ride = run(towards({"dark": True}, mode), 0)
    on_dark = ride.pose[:, 0] + ride.robot.wheels[:, 0].max() > EDGE + 0.1
    assert on_dark.any()
    # a drive takes a moment to slow down
    assert np.abs(ride.twist[on_dark, 0]).max() <= CREEPING + 0.03
    assert Reason.FLOOR_UNSEEN in {tick.decision.reason for tick in ride.ticks}


def test_the_chair_does_not_back_onto_floor_that_it_never_saw():
    rider = {"use": "cohelm.benchmarks.rides.edges:Held", "forward": -1.0}
    ride = run(towards({"height": -0.02}, "stop_only", angle=180.0, rider=rider), 0)
    rear = ride.robot.wheels[:, 0].min()
    backed = np.hypot(*(ride.pose[-1, :2] - ride.pose[0, :2]))
    assert 0.1 < backed < ride.robot.circumscribed_radius + 0.1 + rear + 0.1
    assert ride.ticks[-1].decision.reason is Reason.FLOOR_UNSEEN
    assert np.abs(ride.twist[-1]).max() < 0.03
