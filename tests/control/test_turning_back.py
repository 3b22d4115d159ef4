"""Who turns back finds the chair standing; and the chair brakes as hard as that takes."""

import dataclasses

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.trajectories import limited_trajectory
from cohelm.control.verification import REACTION, TURN_DELAY, Verification, Verifier, turned_back
from cohelm.messages import Status
from cohelm.robots.braking import STANDING, braking
from cohelm.robots.capsule import nearest_on_spine_in_map
from cohelm.testing.scenes import local_problem, walkers

PLANNER = SsMpcDcbf()
RULES, CLEARANCE = PLANNER.parameters.verification, PLANNER.clearance
STEP_TIMES = PLANNER.step * np.arange(PLANNER.parameters.steps)
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
    at, pace, out = position - TURN_DELAY * velocity, np.hypot(*velocity), []
    goes = -pace
    for k in range(round(TURN_DELAY / FINE) + count):
        at = at + FINE * pace * ahead
        pace = max(pace - TURN * FINE, goes)
        if k >= round(TURN_DELAY / FINE):
            out.append(at)
    return np.array(out)


def verifier(problem, rules=RULES):
    now = np.array([problem.twist[0], problem.twist[2]])
    courses = np.zeros(len(problem.people))
    return rules.verifier(problem, CLEARANCE, now, lately(problem), courses)


def touch_at(problem, command, where):
    """When the chair, moving, is touched if it brakes hard after a command, s; +inf: never."""
    robot, now = problem.robot, np.array([problem.twist[0], problem.twist[2]])
    hard = robot.emergency_deceleration
    poses = braking(robot, problem.pose, now, command, hold=REACTION, deceleration=hard, step=FINE)
    moving = np.hypot(*np.diff(poses[:, :2], axis=0).T) > STANDING * FINE
    gaps = [
        nearest_on_spine_in_map(robot.capsule, pose, *spot)[0]
        for pose, spot in zip(poses[1:], where, strict=False)
    ]
    gaps = np.array(gaps) - robot.capsule[4] - problem.people.radius[0]
    touched = np.flatnonzero(moving[: len(gaps)] & (gaps <= 0.0))
    return FINE * touched[0] if len(touched) else np.inf


def test_who_turns_back_unseen_finds_the_chair_standing():
    """Crossing before the chair or walking ahead of it: where driving on is verified, the brakes do
    the rest, or would not if they began at once."""
    rng = np.random.default_rng(5)
    verified, clear = 0, 0
    for _ in range(150):
        speed = rng.uniform(0.1, 1.0)
        at, pace = rng.uniform([0.8, -1.6], [2.5, 0.2]), rng.uniform(1.0, 1.3)
        way = rng.uniform(-2.2, 0.3)
        velocity = pace * np.array([np.cos(way), np.sin(way)])
        problem = scene(people=walkers([[*at, *velocity]]), speed=speed)
        if not verifier(problem).accepts(straight_on(problem, speed)):
            continue
        verified += 1
        where = turned(at, velocity, 400)
        later = touch_at(problem, np.array([speed, 0.0]), where)
        clear += later == np.inf
        assert later == np.inf or touch_at(problem, np.zeros(2), where) <= later + 0.05
    assert 20 < verified < 140
    assert clear > 0.9 * verified


@pytest.mark.parametrize(("turning", "passes"), [(6.0, False), (0.0, True)])
def test_close_behind_somebody_the_chair_does_not_go_fast(turning, passes):
    """0.5 m behind somebody who walks as fast: on the way back he meets a chair that rolls."""
    problem = scene(people=walkers([[1.75, 0.0, 0.8, 0.0]]), speed=0.8)
    rules = RULES.model_copy(update={"turn_back_acceleration": turning})
    assert verifier(problem, rules).accepts(straight_on(problem, 0.8)) is passes


def test_who_has_stood_for_a_while_does_not_turn_back():
    """0.45 m/s measured where nobody has walked: noise of the tracker."""
    problem = scene(people=walkers([[1.45, 0.0, 0.45, 0.0], [1.0, 2.0, 0.0, 0.8]]))
    found = turned_back(
        problem.people,
        problem.predictions,
        np.array([0.2, 0.8]),
        acceleration=RULES.turn_back_acceleration,
    )
    assert np.ptp(found.mean[0], axis=1).max() == 0.0
    assert found.mean[1, 0, -1, 1] < 2.0 - 1.0


def test_it_goes_slower_where_no_way_is_verified_at_its_speed():
    """Nothing passes at more than half the speed; a plan that does is found all the same."""

    class Checks(Verifier):
        def accepts(self, trajectory):
            return bool(trajectory.inputs[:, 0].max() < 0.6)

    class Slow(Verification):
        def verifier(self, *given):
            same = super().verifier(*given)
            return Checks(
                self,
                same.problem,
                same.current_input,
                same.margins,
                returning=same.returning,
                paces=same.paces,
                courses=np.zeros(len(same.problem.people)),
            )

    planner = SsMpcDcbf(PLANNER.parameters.model_copy(update={"verification": Slow()}))
    plan = planner.plan(scene(speed=0.5, wanted=1.0), None)
    assert plan.status is not Status.STOP
    assert 0.0 < plan.inputs[:, 0].max() < 0.6


@pytest.mark.parametrize(("gap", "urgent"), [(0.45, True), (2.5, False)])
def test_hard_braking_is_asked_for_where_ordinary_braking_is_not_enough(gap, urgent):
    """At 0.8 m/s towards somebody who comes: ordinary braking takes 0.4 m, hard braking 0.2 m."""
    problem = scene(people=walkers([[0.8 + gap, 0.0, -1.1, 0.0]]), speed=0.8)
    plan = PLANNER.plan(problem, None)
    assert plan.urgent is urgent
    if urgent:
        assert plan.status is Status.STOP
        assert not plan.brief


def test_the_closer_somebody_is_the_harder_it_brakes():
    """Somebody comes: first it slows down, then it brakes, then it brakes hard."""
    given = []
    for gap in np.arange(2.8, 0.2, -0.2):
        problem = scene(people=walkers([[0.8 + gap, 0.0, -1.1, 0.0]]), speed=0.8)
        plan = PLANNER.plan(problem, None)
        given.append((0.8 - plan.command[0]) / 0.05 + plan.urgent)
    assert given == sorted(given)
    comfort = problem.robot.max_deceleration
    assert given[0] < 0.2 * comfort
    assert comfort + 1e-9 > min(g for g in given if g > 0.5 * comfort)
    assert given[-1] > comfort


@pytest.mark.parametrize("at", [(-1.2, 0.0, 0.8, 0.0), (-0.9, 0.75, 0.75, -0.1)])
def test_nobody_brakes_for_who_follows(at):
    """He walks on behind a chair that drives as fast: braking would bring him closer."""
    problem = scene(people=walkers([at]), speed=0.8)
    assert verifier(problem).brakes_help(straight_on(problem, 0.8))
    assert PLANNER.plan(problem, None).status is not Status.STOP


def test_who_crosses_behind_the_chair_does_not_stop_it():
    problem = scene(people=walkers([[-0.35, 1.15, 0.1, -0.6]]), speed=0.8)
    assert PLANNER.plan(problem, None).status is not Status.STOP


@pytest.mark.parametrize(("behind", "in_time"), [(1.2, False), (4.0, True)])
def test_a_stop_should_end_before_somebody_runs_into_the_back(behind, in_time):
    """He walks at 1.2 m/s behind a chair that stops from 0.6 m/s within 1.5 s."""
    problem = scene(people=walkers([[-behind, 0.0, 1.2, 0.0]]), speed=0.6)
    speeds = np.maximum(0.6 - 0.4 * STEP_TIMES, 0.0)
    inputs = np.stack([speeds, np.zeros_like(speeds)], axis=-1)
    stop = limited_trajectory(
        problem.truncated(PLANNER.parameters.steps), inputs, np.array([0.6, 0.0])
    )
    assert verifier(problem).stands_in_time(stop) is in_time


def test_a_stand_is_not_shorter_than_is_felt():
    """A chair that has come to a stand goes on after 0.4 s, though its way is free, and says so."""
    problem = scene(speed=0.03, wanted=0.8)
    plan = PLANNER.plan(problem, None)
    memory = dataclasses.replace(plan.memory, current_input=np.array([0.03, 0.0]))
    plan = dataclasses.replace(plan, command=np.zeros(3), memory=memory)
    commands, told = [], []
    for k in range(1, 13):
        now = dataclasses.replace(problem, time=0.05 * k, twist=np.zeros(3))
        plan = PLANNER.plan(now, plan)
        commands.append(plan.command[0])
        told.append(plan.reason is not None and not plan.brief)
    assert max(commands[:8]) == 0.0
    assert all(told[:8])
    assert commands[-1] > 0.0
