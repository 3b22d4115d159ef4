"""The rider's motion as a candidate: what is reported of it, and when it wins."""

import dataclasses

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.testing.problems import random_problem

SPEED, TURN = 0.4, 0.25


@pytest.fixture(scope="module")
def free():
    """A problem without people; its robot at rest."""
    problem = random_problem(np.random.default_rng(3), 0).problem
    return dataclasses.replace(problem, twist=np.zeros(3))


def inputs_of(problem, speed, turn):
    steps = len(problem.reference.speeds) - 1
    return np.tile([speed, turn], (steps, 1))


def with_rider(problem, speed=SPEED, turn=TURN, *, yields=False):
    inputs = inputs_of(problem, speed, turn)
    return dataclasses.replace(problem, rider_inputs=inputs, yields=yields)


def test_a_rider_whom_the_chair_does_not_yield_to_changes_no_command(planner, free):
    alone, beside = planner.plan(free, None), planner.plan(with_rider(free), None)
    np.testing.assert_array_equal(alone.command, beside.command)
    np.testing.assert_array_equal(alone.poses, beside.poses)
    assert np.isnan(alone.disagreement)


def test_the_reported_angle_is_that_between_both_motions(planner, free):
    own = planner.plan(with_rider(free), None)
    rider = planner.plan(with_rider(free, yields=True), None)
    k = round(1.5 / planner.step)
    expected = wrap_angle(own.poses[k, 2] - rider.poses[k, 2])
    assert own.disagreement == pytest.approx(expected, abs=1e-9)
    # the chair's own choice does not depend on who leads
    assert rider.disagreement == pytest.approx(own.disagreement, abs=1e-9)


def test_a_chair_that_yields_takes_the_riders_motion(planner, free):
    plan = planner.plan(with_rider(free, yields=True), None)
    assert plan.candidate == "rider"
    assert plan.inputs[-1] == pytest.approx([SPEED, TURN], abs=1e-6)


def test_a_motion_into_a_wall_is_slowed_before_it(planner, free):
    # a wall across the way at 0.25 m before the front: at 0.8 m/s it is met within the 2 s checked
    high = max(x for x, _ in free.robot.footprint)
    angle = free.pose[2]
    ahead = free.pose[:2] + (high + 0.25) * np.array([np.cos(angle), np.sin(angle)])
    walls = dataclasses.replace(
        free.walls, distance=_before(free.walls, ahead, angle).astype(np.float32)
    )
    problem = dataclasses.replace(free, walls=walls)
    plan = planner.plan(with_rider(problem, speed=0.8, turn=0.0, yields=True), None)
    reached = plan.poses[: round(2.0 / planner.step) + 1]
    along = (reached[:, :2] - free.pose[:2]) @ np.array([np.cos(angle), np.sin(angle)])
    assert along.max() < 0.25
    # at 0.8 m/s and 0.48 m/s the wall is met within 2 s
    assert plan.inputs[:, 0].max() < 0.3 * 0.8 + 1e-6 or plan.candidate != "rider"


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
