import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control import Trajectory
from cohelm.control.baselines import Mpc
from cohelm.control.baselines.tracking import along_reference
from cohelm.control.terms.encounter import encounter
from cohelm.control.terms.norms import norm_gap, norm_gradient
from cohelm.messages import Status
from cohelm.robots import load_robot
from cohelm.testing.problems import mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, straight_on, walkers

STEPS, STEP = 25, 0.1
CAPSULE = load_robot("quantum_q6_edge").capsule
KERNEL = {1: 1, 2: 2, "inf": 0}


def scene(**options):
    return local_problem(steps=STEPS, step=STEP, **options)


def drawn(seed, people):
    rng = np.random.default_rng(seed)
    return random_problem(rng, people, steps=STEPS, step=STEP).problem


def met(pose, person):
    """The encounter of a robot at ``pose`` with somebody of radius 0.25 m."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return encounter(CAPSULE, cos, sin, person[0] - pose[0], person[1] - pose[1], 0.25)


def distance(norm, pose, person, along=0.0):
    return norm_gap(met(pose, person), along, CAPSULE[4] + 0.25 + 0.3, KERNEL[norm])


@pytest.mark.parametrize(("norm", "length", "widened"), [(1, 7.0, np.sqrt(2.0)), ("inf", 4.0, 1.0)])
def test_norms_by_hand(norm, length, widened):
    """3 m ahead of the spine's front end and 4 m to its left: 7 and 4 m."""
    h = distance(norm, np.zeros(3), [CAPSULE[2] + 3.0, CAPSULE[3] + 4.0])
    assert h == pytest.approx(length - widened * (CAPSULE[4] + 0.25 + 0.3), abs=1e-5)


@pytest.mark.parametrize("norm", [1, "inf"])
def test_its_gradient_is_the_difference_quotient(norm, rng):
    for _ in range(30):
        pose, person = rng.uniform(-1.0, 1.0, 3), rng.uniform(1.5, 4.0, 2) * rng.choice([-1, 1], 2)
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        gradient = norm_gradient(met(pose, person), cos, sin, 0.3, KERNEL[norm])
        for a in range(3):
            push = np.eye(3)[a] * 1e-6
            ahead, behind = (distance(norm, pose + s * push, person, 0.3) for s in (1.0, -1.0))
            assert gradient[a] == pytest.approx((ahead - behind) / 2e-6, abs=1e-4)


@pytest.mark.parametrize("norm", [1, "inf"])
def test_box_and_diamond_contain_the_disc(norm, rng):
    """Who keeps out of them keeps the distance of norm 2."""
    pose, outside = np.array([0.0, 0.0, 0.4]), 0
    for person in rng.uniform(-4.0, 4.0, (500, 2)):
        if distance(norm, pose, person, 0.4) >= 0.0:
            outside += 1
            assert met(pose, person).gap - 0.3 >= -1e-5
    assert outside > 100


@pytest.mark.parametrize("seed", range(4))
def test_it_knows_where_people_are_and_not_where_they_go(seed):
    problem = drawn(seed, 5)
    still = walkers(np.hstack([problem.people.mean[:, :2], np.zeros((5, 2))]))
    other = dataclasses.replace(problem, predictions=straight_on(still, STEPS, STEP))
    assert identical(Mpc().plan(problem, None), Mpc().plan(other, None))


def test_on_the_reference_its_linearisation_is_the_reference():
    problem = scene(speed=0.8)
    trajectory = along_reference(problem, np.array([0.8, 0.0]))
    assert trajectory.poses == pytest.approx(problem.reference.poses, abs=1e-12)
    plan = Mpc().plan(problem, None)
    # nothing is left to gain, so the quadratic program answers 0
    assert plan.inputs == pytest.approx(trajectory.inputs, abs=1e-6)
    assert sum(plan.costs.values()) < 1e-9


def test_beside_the_reference_the_linearisation_joins_it():
    problem = scene(speed=0.8, pose=(0.0, 0.0, 0.0))
    moved = dataclasses.replace(problem, pose=np.array([0.0, 0.3, 0.2]))
    trajectory = along_reference(moved, np.array([0.8, 0.0]))
    aside = np.abs(trajectory.poses[:, 1])
    assert aside[-1] < 0.5 * aside[0]
    assert abs(trajectory.poses[-1, 2]) < 0.2


def test_one_quadratic_program_for_each_profile():
    problem = drawn(0, 4)
    assert Mpc().plan(problem, None).iterations == 1
    only = Mpc(Mpc.Parameters(profiles=(0.5,)))
    assert only.plan(problem, None).status in Status


@pytest.mark.parametrize("norm", [1, 2, "inf"])
def test_it_goes_round_who_stands_there(norm):
    parameters = Mpc.Parameters(norm=norm)
    person = walkers([[2.2, 0.25, 0.0, 0.0]])
    plan = Mpc(parameters).plan(scene(people=person, speed=0.7), None)
    assert plan.poses[-1, 1] < 0.0 or plan.inputs[-1, 0] < 0.4


@pytest.mark.parametrize("seed", range(4))
def test_turned_and_mirrored_worlds_have_turned_and_mirrored_plans(seed):
    problem = drawn(seed, 3)
    plain = Mpc().plan(problem, None)
    other = Mpc().plan(turned(problem, np.array([2.0, -1.0, 0.7])), None)
    assert np.abs(plain.command - other.command).max() < 1e-5
    flipped = Mpc().plan(mirrored(problem), None)
    assert np.abs(plain.command - flipped.command * [1.0, 1.0, -1.0]).max() < 1e-5


def test_a_chair_at_its_goal_stays_there():
    plan = Mpc().plan(scene(speed=0.0, wanted=0.0), None)
    assert np.abs(plan.inputs).max() < 1e-6


def test_its_motion_is_what_its_inputs_lead_to():
    problem = drawn(3, 4)
    plan = Mpc().plan(problem, None)
    poses = problem.robot.motion_model.rollout(problem.pose, plan.inputs, plan.step)
    assert plan.poses == pytest.approx(poses)
    assert isinstance(along_reference(problem, problem.twist[[0, 2]]), Trajectory)
