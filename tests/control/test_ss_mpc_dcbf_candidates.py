"""Choice among candidates: sides, commitment, lateness, hypotheses, contact."""

import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control import SsMpcDcbf
from cohelm.control.planner_memory import PlannerMemory, class_changes, unexpired_memory
from cohelm.control.ss_mpc_dcbf import CONTACT_WAIT
from cohelm.control.trajectories import braking_trajectory, limited_trajectory
from cohelm.control.verification import Verification
from cohelm.messages import RiderProfile, Status
from cohelm.robots import Robot, move
from cohelm.robots.clearance import Clearance
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem, straight_on, walkers

PLANNER = SsMpcDcbf()
TICK = 0.05


def scene(**given):
    return local_problem(steps=PLANNER.steps, step=PLANNER.step, **given)


def ridden(person, ticks, **changes):
    """Poses and plans of a chair that follows the x axis at 0.7 m/s, commands obeyed at once."""
    pose, twist, plan = np.zeros(3), np.array([0.5, 0.0, 0.0]), None
    poses, plans = [], []
    for tick in range(ticks):
        time = tick * TICK
        moved = np.array(person, dtype=float)
        moved[:2] += time * moved[2:]
        plain = scene(people=walkers([moved], time=time), pose=pose, speed=float(twist[0]))
        reference = plain.reference
        ahead = pose[0] + 0.7 * reference.step * np.arange(len(reference.speeds))
        along = np.column_stack([ahead, np.zeros((len(ahead), 2))])
        problem = dataclasses.replace(
            plain,
            time=time,
            twist=twist,
            reference=dataclasses.replace(reference, poses=along, speeds=np.full(len(ahead), 0.7)),
            **changes,
        )
        plan = PLANNER.plan(problem, plan)
        twist = plan.command
        pose = move(pose, twist, TICK)
        poses.append(pose)
        plans.append(plan)
    return np.array(poses), plans


@pytest.mark.parametrize("person", [(3.5, 0.0, 0.0, 0.0), (5.0, 0.02, -0.4, 0.0)])
def test_a_side_once_taken_is_kept(person):
    """Somebody dead ahead, standing or coming: both sides are as good, and one is chosen."""
    poses, plans = ridden(person, 60)
    ends = np.array([plan.poses[:, 1][np.abs(plan.poses[:, 1]).argmax()] for plan in plans])
    clear = ends[np.abs(ends) > 0.2]
    assert len(clear) > 20
    assert len(np.unique(np.sign(clear))) == 1
    assert all(plan.status is not Status.STOP for plan in plans)
    assert np.abs(poses[:, 1]).max() > 0.1


@pytest.mark.parametrize(("side", "sign"), [("right", -1.0), ("left", 1.0)])
def test_the_rider_says_on_which_side_to_pass(side, sign):
    """To keep right of somebody dead ahead leads to negative y."""
    poses, _ = ridden((3.5, 0.0, 0.0, 0.0), 50, profile=RiderProfile(passing_side=side))
    assert sign * poses[:, 1][np.abs(poses[:, 1]).argmax()] > 0.1


def test_the_score_is_the_objective_and_the_terms_of_the_choice():
    """Two ways round somebody ahead: the wrong side, another class and a new plan cost as told."""
    plain = scene(people=walkers([[4.0, 0.0, -0.5, 0.0]]), speed=0.7)
    problem = dataclasses.replace(plain, profile=RiderProfile(passing_side="left"))
    choice = PLANNER.parameters.choice
    first = PLANNER.plan(problem, None)
    assert first.memory.person_sides.tolist() == [-1]
    cycle = PLANNER._prepare(dataclasses.replace(problem, time=TICK), first)
    candidates = cycle.sample(PLANNER.parameters.sampling, None)
    assert {-1, 1} <= {int(each.passing_sides[1]) for each in candidates}
    for each in candidates:
        added = choice.replacing
        added += (choice.passing_side + choice.switching) * (each.passing_sides[1] == 1)
        assert each.score == pytest.approx(each.cost + added)
        assert each.by_term.sum() == pytest.approx(each.score)
        assert (each.by_term >= 0.0).all()
    [kept] = cycle.evaluate([first.inputs], ["previous"])
    assert kept.by_term[-1] == 0.0


def test_class_changes_count_the_people_passed_on_the_other_side():
    who = walkers([[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [3.0, 0.0, 0.0, 0.0]])
    # ids 1, 2, 3; of 9 and 3 something is remembered
    memory = PlannerMemory(
        time=0.0,
        path_side=1,
        person_id=np.array([9, 3]),
        person_sides=np.array([-1, 1]),
        tail=np.zeros((0, 2)),
        person_speeds=np.zeros(2),
        person_paces=np.zeros(2),
        person_courses=np.zeros(2),
        input_time=0.0,
        current_input=np.zeros(2),
    )
    ways = np.array([[1, 0, 1, 1], [0, -1, -1, 1], [-1, 1, 1, -1], [1, 1, 1, -1]])
    assert class_changes(ways, who, memory).tolist() == [0, 0, 2, 1]
    assert class_changes(ways, who, None).tolist() == [0, 0, 0, 0]


def test_the_memory_expires():
    plan = PLANNER.plan(scene(speed=0.5), None)
    assert isinstance(unexpired_memory(plan, 0.5), PlannerMemory)
    for time in (-0.1, 5.0):
        assert unexpired_memory(plan, time) is None
    assert unexpired_memory(None, 0.0) is None


def test_a_late_tick_has_a_smaller_budget():
    problem = random_problem(np.random.default_rng(3), 5, steps=PLANNER.steps).problem
    late = dataclasses.replace(problem, late=0.2)
    p = PLANNER.parameters
    assert PLANNER.plan(problem, None).iterations <= p.candidates * p.iterations
    plan = PLANNER.plan(late, None)
    assert plan.iterations <= 1
    assert identical(plan, PLANNER.plan(late, None))


@pytest.mark.parametrize("seed", range(8))
def test_holonomic_robots_keep_their_limits(seed):
    plain = random_problem(np.random.default_rng(seed), seed % 4).problem
    build = plain.robot.model_dump() | {"kinematics": "holonomic", "max_reverse_speed": 1.0}
    problem = dataclasses.replace(plain, robot=Robot(**build))
    plan = PLANNER.plan(problem, None)
    assert plan.inputs.shape == (PLANNER.parameters.steps, 3)
    assert np.isfinite(plan.inputs).all()
    speeds = np.hypot(plan.inputs[:, 0], plan.inputs[:, 1])
    assert speeds.max() <= max(problem.top_speed, np.hypot(*problem.twist[:2])) + 1e-6
    assert np.abs(plan.inputs[:, 2]).max() <= problem.robot.max_turn_rate + 1e-6


def who_may_turn(share):
    """She walks along beside the chair's way; with probability ``share`` she steps into it."""
    who = walkers([[1.1, -0.95, 0.0, 0.0]])
    plain = straight_on(who, PLANNER.steps, PLANNER.step)
    times = PLANNER.step * np.arange(PLANNER.steps + 1)
    aside = np.stack([0.0 * times, 1.5 * times], axis=-1)
    velocity = np.stack([plain.velocity[:, 0], plain.velocity[:, 0] + [0.0, 1.5]], axis=1)
    two = dataclasses.replace(
        plain,
        names=("stands", "steps_in"),
        weight=np.array([[1.0 - share, share]]),
        mean=np.concatenate([plain.mean, plain.mean + aside], axis=1),
        velocity=velocity,
        deviation=np.repeat(plain.deviation, 2, axis=1),
    )
    return dataclasses.replace(scene(people=who, speed=0.8), predictions=two)


@pytest.mark.parametrize(("share", "clear"), [(0.05, True), (0.3, False)])
def test_probable_hypotheses_bind_emergency_braking(share, clear):
    problem = who_may_turn(share)
    ahead = limited_trajectory(problem, np.tile([0.8, 0.0], (25, 1)), np.array([0.8, 0.0]))
    rules = Verification(people_acceleration=0.0)
    clearance = Clearance(now=0.12, growth=0.0)
    checks = rules.verifier(problem, clearance, np.array([0.8, 0.0]), np.zeros(1), np.zeros(1))
    assert checks.accepts(ahead) is clear


def test_the_chair_waits_after_a_contact():
    touched = dataclasses.replace(scene(), last_contact=0.0)
    soon = PLANNER.plan(dataclasses.replace(touched, time=0.9 * CONTACT_WAIT), None)
    assert soon.status is Status.STOP
    later = PLANNER.plan(dataclasses.replace(touched, time=1.1 * CONTACT_WAIT), soon)
    assert later.status is not Status.STOP


def test_the_reason_of_a_long_contact_stays_once_told():
    """Somebody walks against the chair for 2.5 s; it stands until a second after that."""
    ends, plan, told = 2.5, None, []
    for k in range(100):
        time = 0.05 * k
        problem = dataclasses.replace(scene(), time=time, last_contact=min(time, ends))
        plan = PLANNER.plan(problem, plan)
        if plan.status is not Status.STOP:
            break
        told.append(not plan.brief)
    assert time == pytest.approx(ends + CONTACT_WAIT, abs=0.11)
    assert told == sorted(told)
    assert told[-1]


def test_the_report_of_a_hard_stop_is_that_of_its_own_trajectory():
    problem = scene(people=walkers([[1.5, 0.0, -0.8, 0.0]]), speed=0.9)
    plan = PLANNER.plan(problem, None)
    assert plan.candidate == "braking"
    prepared = PLANNER.control.prepare(
        problem, np.array([0.9, 0.0]), wall_margin=PLANNER.parameters.verification.wall_margin
    )
    assert plan.slack == pytest.approx(prepared.evaluate(plan.inputs).slack, abs=1e-6)


def test_a_trajectory_may_be_shorter_than_the_reference():
    problem, inputs = scene(speed=0.8), np.tile([0.8, 0.1], (9, 1))
    short = dataclasses.replace(problem, reference=problem.truncated(9).reference)
    made = PLANNER.control.prepare(short, np.array([0.8, 0.0])).trajectory(inputs)
    costs = [PLANNER.control.evaluate(each, made).cost for each in (problem, short)]
    assert costs[0] == pytest.approx(costs[1])


def test_braking_ends_a_turn_on_the_spot_no_faster_than_the_drive_does():
    problem = dataclasses.replace(scene(), twist=np.array([0.0, 0.0, 1.0]))
    trajectory = braking_trajectory(problem, np.array([0.0, 1.0]), 25)
    # 1 rad/s at 2.5 rad/s² is 0.4 s, with a step of 0.16 s: still turning in the second one
    turns = trajectory.inputs[:, 1]
    assert (np.diff(turns) <= 1e-9).all()
    assert turns[1] > 0.2
    assert turns[4:].max() < 1e-9
