"""A drive that obeys late, or is kicked aside by its casters, in verification."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.control.drive_error import SWING, DriveError, delayed
from cohelm.control.trajectories import limited_trajectory
from cohelm.control.verification import Verification
from cohelm.robots.clearance import Clearance
from cohelm.testing.problems import field_of
from cohelm.testing.scenes import local_problem

STEP, STEPS = 0.16, 24
WALL = 0.02


def scene(speed=0.0, wall=None):
    """A chair at the origin, heading along x; a wall across or beside its way."""
    problem = local_problem(steps=STEPS, step=STEP, speed=speed)
    return problem if wall is None else dataclasses.replace(
        problem, walls=field_of(np.array([wall]), problem.pose)
    )  # fmt: skip


def verifier(problem, speed=0.0, **drive):
    rules = Verification(wall_margin=WALL, drive=DriveError(**drive))
    none = np.zeros(0)
    return rules.verifier(problem, Clearance(), np.array([speed, 0.0]), none, none)


def driving(problem, speed, now):
    inputs = np.tile([speed, 0.0], (STEPS, 1))
    return limited_trajectory(problem, inputs, np.array([now, 0.0]))


def front(robot):
    """Foremost point of the discs that contain the footprint, m."""
    return float((robot.discs[:, 0] + robot.discs[:, -1]).max())


@given(delay=st.floats(0.0, 0.5), seed=st.integers(0, 2**31))
def test_late_inputs_cover_the_way_of_punctual_ones(delay, seed):
    """∫u(t − d) over the horizon = d·u_{−1} + ∫u over the horizon less its last d seconds."""
    rng = np.random.default_rng(seed)
    inputs, now = rng.normal(size=(STEPS, 2)), rng.normal(size=2)
    inputs[-4:] = inputs[-1]  # constant over the last 0.64 s, which hold the longest delay
    late = delayed(inputs, now, STEP, delay)
    expected = delay * now + STEP * inputs.sum(axis=0) - delay * inputs[-1]
    assert STEP * late.sum(axis=0) == pytest.approx(expected, abs=1e-9)


def test_a_drive_without_error_changes_nothing():
    problem = scene(speed=0.8)
    ahead = driving(problem, 0.8, 0.8)
    exact = DriveError()
    assert exact.driven(ahead, problem.robot) is ahead.poses
    assert exact.displaced(ahead.poses, 0.0, problem.robot) == (ahead.poses,)


@pytest.mark.parametrize(("spare", "free"), [(0.02, False), (0.14, True)])
def test_a_stop_that_begins_late_needs_the_way_of_the_delay(spare, free):
    """At 0.8 m/s a delay of 0.1 s takes 8 cm more before a wall."""
    speed, delay = 0.8, 0.1
    problem = scene(speed=speed)
    inputs = np.clip(speed - 0.6 * STEP * np.arange(1, STEPS + 1), 0.0, None)
    stop = limited_trajectory(
        problem, np.column_stack([inputs, np.zeros(STEPS)]), np.array([speed, 0.0])
    )
    end = stop.poses[-1, 0] + front(problem.robot) + WALL + spare
    walled = scene(speed=speed, wall=[-1.0, 0.0, -end])
    assert verifier(walled, speed).contact(stop) == np.inf
    late = verifier(walled, speed, delay=delay)
    assert (late.contact(stop) == np.inf) is free


def test_braking_begins_later_by_the_delay():
    """Constant speed for the delay: the stop is longer by v·d."""
    problem, speed = scene(speed=0.8), 0.8
    stops = [
        verifier(problem, speed, delay=d)._braking(np.array([speed, 0.0]), 1.0)[-1, 0]
        for d in (0.0, 0.1)
    ]
    assert stops[1] - stops[0] == pytest.approx(0.1 * speed, abs=0.005)


@pytest.mark.parametrize("kick", [0.01, 0.05])
@pytest.mark.parametrize("now", [0.0, -0.4])
def test_casters_kick_a_chair_that_sets_off_or_reverses(kick, now):
    """The displacement begins at 0, grows with the way, and ends at the bound on either side."""
    problem = scene(speed=now)
    there = np.column_stack([np.linspace(0.0, 1.0, 26), np.zeros(26), np.zeros(26)])
    poses = DriveError(kick=kick).displaced(there, now, problem.robot)
    left, right = poses[1][:, 1], poses[2][:, 1]
    assert left[0] == 0.0
    assert (np.diff(left) >= 0.0).all()
    assert left[-1] == pytest.approx(kick)
    assert right == pytest.approx(-left)


def test_casters_that_trail_already_do_not_kick():
    """v²/2a of a chair as fast as this is just more, or just less, than the way of the swing."""
    robot = scene().robot
    for share, kicked in ((1.01, 1), (0.99, 3)):
        speed = float(np.sqrt(share * 2.0 * robot.max_acceleration * SWING))
        ahead = driving(scene(speed=speed), speed, speed)
        assert len(DriveError(kick=0.05).displaced(ahead.poses, speed, robot)) == kicked


@pytest.mark.parametrize(("gap", "free"), [(0.02, False), (0.06, True)])
def test_a_chair_that_sets_off_beside_a_wall_keeps_the_kick_clear(gap, free):
    """A kick of 3 cm, and a wall that converges to ``gap`` beyond its margin at the end."""
    ahead, robot = driving(scene(), 0.4, 0.0), scene().robot
    normal = np.array([-0.05, -1.0]) / np.hypot(0.05, 1.0)
    foremost = robot.discs[robot.discs[:, 0].argmax()]
    nearest = ahead.poses[-1, :2] + foremost[:2]
    problem = scene(wall=[*normal, normal @ nearest - foremost[2] - WALL - gap])
    assert verifier(problem).contact(ahead) == np.inf
    assert (verifier(problem, kick=0.03).contact(ahead) == np.inf) is free


def test_a_chair_that_touches_a_wall_may_still_leave():
    """The kick is 0 at the start, and a wall margin is never more than the gap there."""
    robot = scene().robot
    half = float((robot.discs[:, 1] + robot.discs[:, -1]).max())
    away = np.array([-0.2, -1.0]) / np.hypot(0.2, 1.0)
    problem = scene(wall=[-away[0], away[1], -(half + 0.05)])
    ahead = driving(problem, 0.6, 0.0)
    assert verifier(problem, kick=0.02).contact(ahead) == np.inf
