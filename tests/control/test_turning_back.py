"""Who turns back finds the chair standing; and the chair brakes as hard as that takes."""

import dataclasses

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.trajectories import limited_trajectory
from cohelm.control.verification import Verification
from cohelm.messages import Status
from cohelm.robots.braking import STANDING, braking
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.testing.scenes import local_problem, walkers

PLANNER = SsMpcDcbf()
RULES, CLEARANCE = PLANNER.parameters.verification, PLANNER.clearance
FINE = 0.01
TURN = 5.0
"""A little less than is reckoned with, m/s²."""


def scene(**given):
    return local_problem(steps=PLANNER.steps, step=PLANNER.step, **given)


def lately(problem):
    """Speeds of people who have walked as they do now, (n,)."""
    return np.hypot(*problem.people.mean[:, 2:].T)


def straight_on(problem, speed):
    inputs = np.tile([speed, 0.0], (PLANNER.parameters.steps, 1))
    return limited_trajectory(
        problem.truncated(PLANNER.parameters.steps), inputs, np.array([speed, 0.0])
    )


def turned(position, velocity, count):
    """Where somebody is every ``FINE`` s from now on who began to turn ``unseen`` ago."""
    ahead = velocity / np.hypot(*velocity)
    at, pace, out = position - RULES.turn_back_delay * velocity, np.hypot(*velocity), []
    goes = -pace
    for k in range(round(RULES.turn_back_delay / FINE) + count):
        at = at + FINE * pace * ahead
        pace = max(pace - TURN * FINE, goes)
        if k >= round(RULES.turn_back_delay / FINE):
            out.append(at)
    return np.array(out)


def test_who_turns_back_unseen_finds_the_chair_standing():
    """Crossing before the chair or walking ahead of it: where driving on is verified, the brakes do
    the rest."""
    rng = np.random.default_rng(5)
    verified = 0
    for _ in range(150):
        speed = rng.uniform(0.1, 1.0)
        at, pace = rng.uniform([0.8, -1.6], [2.5, 0.2]), rng.uniform(1.0, 1.3)
        way = rng.uniform(-2.2, 0.3)
        velocity = pace * np.array([np.cos(way), np.sin(way)])
        problem = scene(people=walkers([[*at, *velocity]]), speed=speed)
        if not RULES.passes(problem, straight_on(problem, speed), CLEARANCE, lately(problem)):
            continue
        verified += 1
        robot, now = problem.robot, np.array([speed, 0.0])
        hard = robot.emergency_deceleration
        poses = braking(
            robot, problem.pose, now, now, hold=RULES.reaction, deceleration=hard, step=FINE
        )
        moving = np.hypot(*np.diff(poses[:, :2], axis=0).T) > STANDING * FINE
        where = turned(at, velocity, len(poses))
        gaps = np.array(
            [
                nearest_on_spine_in_map(robot.capsule, pose, *spot)[0]
                for pose, spot in zip(poses[1:], where, strict=False)
            ]
        )
        gaps = gaps[: len(moving)] - robot.capsule[4] - problem.people.radius[0]
        assert (gaps[moving[: len(gaps)]] > 0.0).all()
    assert 20 < verified < 140


@pytest.mark.parametrize(("turning", "passes"), [(6.0, False), (0.0, True)])
def test_close_behind_somebody_the_chair_does_not_go_fast(turning, passes):
    """0.5 m behind somebody who walks as fast: on the way back he meets a chair that rolls."""
    problem = scene(people=walkers([[1.75, 0.0, 0.8, 0.0]]), speed=0.8)
    rules = RULES.model_copy(update={"turn_back_acceleration": turning})
    assert rules.passes(problem, straight_on(problem, 0.8), CLEARANCE, lately(problem)) is passes


def test_who_has_stood_for_a_while_does_not_turn_back():
    """0.45 m/s measured where nobody has walked: noise of the tracker."""
    problem = scene(people=walkers([[1.45, 0.0, 0.45, 0.0], [1.0, 2.0, 0.0, 0.8]]))
    found = RULES._turned_back(problem, np.array([0.2, 0.8]))
    assert np.ptp(found.mean[0], axis=1).max() == 0.0
    assert found.mean[1, 0, -1, 1] < 2.0 - 1.0


def test_it_goes_slower_where_no_way_is_verified_at_its_speed():
    """Nothing passes at more than half the speed; a plan that does is found all the same."""

    class Slow(Verification):
        def passes(self, problem, trajectory, clearance, speeds):
            return bool(trajectory.inputs[:, 0].max() < 0.6)

    planner = SsMpcDcbf(PLANNER.parameters.model_copy(update={"verification": Slow()}))
    plan = planner.plan(scene(speed=0.5, wanted=1.0), None)
    assert plan.status is not Status.STOP
    assert 0.0 < plan.inputs[:, 0].max() < 0.6


@pytest.mark.parametrize(("gap", "urgent"), [(0.45, True), (2.5, False)])
def test_hard_braking_is_asked_for_where_ordinary_braking_is_not_enough(gap, urgent):
    """At 0.8 m/s towards somebody who comes: ordinary braking takes 0.4 m, hard braking 0.2 m."""
    problem = scene(people=walkers([[0.8 + gap, 0.0, -1.1, 0.0]]), speed=0.8)
    now = np.array([0.8, 0.0])
    rules = Verification()
    assert rules.needs_emergency_braking(problem, now, CLEARANCE, lately(problem)) is urgent
    if urgent:
        stop = PLANNER.plan(dataclasses.replace(problem), None)
        assert stop.status is Status.STOP
        assert stop.urgent
