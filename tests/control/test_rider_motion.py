"""The rider's motion beside the plan: what is reported of it, and when."""

import dataclasses

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.testing.problems import random_problem

SPEED, TURN = 0.4, 0.25
FAST = 0.8


@pytest.fixture(scope="module")
def free():
    """A problem without people; its robot at rest."""
    problem = random_problem(np.random.default_rng(3), 0).problem
    return dataclasses.replace(problem, twist=np.zeros(3))


def with_rider(problem, speed=SPEED, turn=TURN):
    steps = len(problem.reference.speeds) - 1
    return dataclasses.replace(problem, rider_inputs=np.tile([speed, turn], (steps, 1)))


def test_the_riders_motion_changes_no_command(planner, free):
    alone, beside = planner.plan(free, None), planner.plan(with_rider(free), None)
    np.testing.assert_array_equal(alone.command, beside.command)
    np.testing.assert_array_equal(alone.poses, beside.poses)
    assert np.isnan(alone.disagreement)


@pytest.mark.parametrize("turn", [-0.25, 0.0, 0.25])
def test_the_reported_angle_is_that_between_both_motions(planner, free, turn):
    # at the rider's twist already, so that no acceleration limit delays their motion
    going = dataclasses.replace(free, twist=np.array([SPEED, 0.0, turn]))
    plan = planner.plan(with_rider(going, turn=turn), None)
    k = round(1.5 / planner.step)
    heading = free.pose[2] + turn * k * planner.step
    expected = wrap_angle(plan.poses[k, 2] - heading)
    assert plan.disagreement == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.25])
def test_a_turn_on_the_spot_counts_while_it_is_free(planner, free, turn):
    plan = planner.plan(with_rider(free, speed=0.0, turn=turn), None)
    assert np.isfinite(plan.disagreement)


@pytest.mark.parametrize(("gap", "counts"), [(3.0, True), (0.5, False), (0.05, True)])
def test_a_way_counts_where_it_is_verified_or_stands_before_a_wall(planner, free, gap, counts):
    # 0.5 m: at 30 % of 0.8 m/s it still comes closer than the 2 cm of the verification;
    # 0.05 m: candidates are slowed before walls, and one that stands is verified
    plan = planner.plan(with_rider(_with_wall_ahead(free, gap), speed=FAST, turn=0.0), None)
    assert plan.candidate not in {"stopping", "braking"}
    assert np.isfinite(plan.disagreement) == counts


def _with_wall_ahead(problem, gap):
    """Put a straight wall across the way of the robot, ``gap`` m before its front."""
    angle = problem.pose[2]
    ahead = max(x for x, _ in problem.robot.footprint) + gap
    point = problem.pose[:2] + ahead * np.array([np.cos(angle), np.sin(angle)])
    distance = _before(problem.walls, point, angle).astype(np.float32)
    return dataclasses.replace(problem, walls=dataclasses.replace(problem.walls, distance=distance))


def _before(field, point, angle):
    """Distances to a straight wall through a point, across a direction."""
    rows, cols = field.distance.shape
    c, r = np.meshgrid(np.arange(cols) + 0.5, np.arange(rows) + 0.5)
    x, y, theta = field.X_MG
    u, v = c * field.resolution, r * field.resolution
    points = np.stack(
        [x + u * np.cos(theta) - v * np.sin(theta), y + u * np.sin(theta) + v * np.cos(theta)], -1
    )
    return (point - points) @ np.array([np.cos(angle), np.sin(angle)])
