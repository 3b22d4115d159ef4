"""Laws that hold for any plan, whatever the weights."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings

from cohelm.arrays import identical
from cohelm.control import SsMpcDcbf, without_people
from cohelm.control.candidates import CHOICES
from cohelm.control.objective_tables import TERMS
from cohelm.control.terms.barrier import REACH
from cohelm.control.warm_start import estimate_current_input
from cohelm.geometry import transform
from cohelm.maps import distance_field
from cohelm.messages import Groups, Reason, Status
from cohelm.robots.braking import STANDING
from cohelm.social import PersonalSpace
from cohelm.testing.problems import mirrored, problem_of, random_problem, turned
from cohelm.testing.scenes import local_problem, open_floor, room, walkers
from cohelm.testing.strategies import local_problems, poses

PLANNER = SsMpcDcbf()
STEPS, STEP = PLANNER.steps, PLANNER.step
N = PLANNER.parameters.steps
TICK = 0.05


def scene(**given_):
    return local_problem(steps=STEPS, step=STEP, **given_)


def drawn(seed, people, *, hopeless=False):
    return random_problem(np.random.default_rng(seed), people, hopeless=hopeless).problem


def check_sound(plan, problem):
    """Finite, a rollout of its inputs, a command that the chair can take up."""
    robot = problem.robot
    for array in (plan.command, plan.inputs, plan.poses, [plan.slack]):
        assert np.isfinite(array).all()
    assert not np.isnan(plan.smallest_barrier)
    rolled = robot.motion_model.rollout(problem.pose, plan.inputs, plan.step)
    assert np.abs(rolled - plan.poses).max() < 1e-9
    assert np.array_equal(plan.command, robot.motion_model.twist(plan.inputs[0]))
    low, high, rise, fall = robot.motion_model.bounds(robot.limits)
    now = estimate_current_input(problem, None)  # odometry tells of no more than the chair can do
    change = np.diff(np.vstack([now, plan.inputs]), axis=0)
    assert (change <= rise * STEP + 1e-6).all()
    assert (change >= -fall * STEP - 1e-6).all()
    high = np.minimum(high, [problem.speed_limit, np.inf])
    # who is beyond a limit already does not go further beyond it
    assert (plan.inputs[0] <= np.maximum(high, now) + 1e-6).all()
    assert (plan.inputs[0] >= np.minimum(low, now) - 1e-6).all()
    assert (plan.status is Status.STOP) == (plan.reason is Reason.NO_SAFE_PLAN)


@settings(max_examples=60)
@given(local_problems(steps=STEPS, step=STEP))
def test_limits_hold_for_any_problem(problem):
    first = PLANNER.plan(problem, None)
    check_sound(first, problem)
    later = dataclasses.replace(problem, time=TICK, twist=first.command)
    check_sound(PLANNER.plan(later, first), later)


@pytest.mark.parametrize("seed", range(30))
def test_the_hopeless_gets_a_plan_or_a_stop(seed):
    """People inside the chair, walls through it, twice the speed it may have."""
    problem = drawn(seed, seed % 7, hopeless=True)
    check_sound(PLANNER.plan(problem, None), problem)


@pytest.mark.parametrize("name", ["person on top", "inside a wall", "too fast"])
def test_infeasible_by_design(name):
    walls = distance_field(room(boxes=[(3.0, 3.0, 5.0, 5.0)]))
    problem = {
        "person on top": scene(people=walkers([[0.0, 0.0, 0.0, 0.0]]), speed=0.5),
        "inside a wall": scene(walls=walls, pose=(4.0, 4.0, 0.3), speed=0.5),
        "too fast": scene(speed=3.0),
    }[name]
    problem = dataclasses.replace(problem, speed_limit=0.4)
    plan = PLANNER.plan(problem, None)
    check_sound(plan, problem)
    if name == "too fast":
        assert plan.command[0] < 3.0
    else:
        assert plan.status is not Status.OK


@pytest.mark.parametrize("seed", range(5))
def test_nobody_there_changes_nothing(seed):
    problem = drawn(seed, 0)
    assert identical(PLANNER.plan(problem, None), PLANNER.plan(without_people(problem), None))


@pytest.mark.parametrize("seed", range(6))
def test_a_person_far_away_changes_nothing(seed):
    problem = drawn(seed, 0)
    away = transform(problem.pose, np.array([-25.0, 10.0]))
    who = dataclasses.replace(walkers([[*away, 0.5, 0.0]]), time=problem.time)
    other = problem_of(
        robot=problem.robot,
        pose=problem.pose,
        twist=problem.twist,
        reference=problem.reference,
        people=who,
        walls=problem.walls,
    )
    alone, together = PLANNER.plan(problem, None), PLANNER.plan(other, None)
    assert np.array_equal(alone.inputs, together.inputs)
    assert alone.status is together.status


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("X", [(0.0, 0.0, np.pi / 2), (3.0, -7.0, 0.4), (-11.0, 2.0, -2.5)])
def test_turning_the_world_turns_the_plan(seed, X):
    """Up to the tolerance of the quadratic programs; the search turns exactly."""
    problem = drawn(seed, seed % 4)
    plain, other = PLANNER.plan(problem, None), PLANNER.plan(turned(problem, np.array(X)), None)
    assert np.abs(plain.command - other.command).max() < 1e-4
    assert plain.status is other.status
    moved = transform(np.array(X), plain.poses[:, :2])
    assert np.abs(moved - other.poses[:, :2]).max() < 2e-3


@given(poses(20.0))
@settings(max_examples=15)
def test_where_the_map_begins_does_not_matter(X):
    problem = drawn(11, 3)
    plain, other = PLANNER.plan(problem, None), PLANNER.plan(turned(problem, X), None)
    assert np.abs(plain.command - other.command).max() < 1e-4


@pytest.mark.parametrize("seed", range(10))
def test_a_mirrored_world_has_a_mirrored_plan(seed):
    problem = drawn(seed, seed % 4)
    plain, other = PLANNER.plan(problem, None), PLANNER.plan(mirrored(problem), None)
    assert np.abs(plain.inputs - other.inputs * [1.0, -1.0]).max() < 1e-6


@pytest.mark.parametrize("seed", range(5))
def test_the_same_input_has_the_same_output(seed):
    """Two planners, and one that has planned other things before."""
    problem = drawn(seed, 6)
    first = SsMpcDcbf().plan(problem, None)
    PLANNER.plan(drawn(seed + 50, 3), None)
    assert identical(PLANNER.plan(problem, None), first)
    later = dataclasses.replace(problem, time=TICK)
    assert identical(PLANNER.plan(later, first), SsMpcDcbf().plan(later, first))


def gaps(problem, poses_):
    """Footprint to bodies by the definition: 201 discs along the spine, (n, N+1)."""
    capsule = problem.robot.capsule
    share = np.linspace(0.0, 1.0, 201)[:, None]
    spine = (1.0 - share) * capsule[:2] + share * capsule[2:4]
    points = transform(poses_[:, None, :], spine)
    people = problem.predictions.mean[:, 0, : len(poses_)]
    away = np.linalg.norm(points[None] - people[:, :, None], axis=-1).min(axis=-1)
    return away - capsule[4] - problem.people.radius[:, None]


def test_the_barrier_of_bodies_is_violated_by_no_more_than_the_reported_slack():
    """Eq. (9): h_{k+1} ≥ (1 − γ) h_k − s, h with its growing margin and saturated at 1 m."""
    gamma, law = PLANNER.parameters.terms.bodies.gamma, PLANNER.clearance
    age = np.arange(N + 1) * STEP
    growing = np.minimum(law.now + law.growth * age, law.upper)
    without_slack = 0
    for seed in range(40):
        problem = drawn(seed, 1 + seed % 3)
        plan = PLANNER.plan(problem, None)
        speed = np.hypot(*problem.people.mean[:, 2:].T)
        share = law.standing + (1.0 - law.standing) * np.minimum(speed / 0.5, 1.0)
        h = np.minimum(gaps(problem, plan.poses) - share[:, None] * growing, REACH)
        # 201 discs miss the nearest point of a spine of 0.89 m by at most 2.2 mm: 1e-5 m at 0.3 m
        assert (h[:, 1:] - (1.0 - gamma) * h[:, :-1]).min() > -plan.slack - 1e-4
        without_slack += plan.slack < 1e-9
    assert without_slack >= 5


@pytest.mark.parametrize("seed", range(8))
def test_the_costs_by_term_add_up_to_the_score_that_chose_the_plan(seed):
    """Of a first plan: the objective, and nothing for leaving a class."""
    problem = drawn(seed, seed % 5)
    plan = PLANNER.plan(problem, None)
    assert set(plan.costs) == {*TERMS, *CHOICES}
    assert min(plan.costs.values()) >= 0.0
    assert plan.costs["switching"] == 0.0
    assert sum(plan.costs[name] for name in TERMS) == pytest.approx(plan.memory.lowest_cost)
    later = dataclasses.replace(problem, time=TICK, twist=plan.command)
    following = PLANNER.plan(later, plan)
    replaced = following.candidate != "previous"
    assert following.costs["replacing"] == PLANNER.parameters.choice.replacing * replaced


@pytest.mark.parametrize("seed", range(8))
def test_the_order_of_people_does_not_matter(seed):
    problem = drawn(seed, 2 + seed % 4)
    order = np.random.default_rng(seed).permutation(len(problem.people))
    plain, other = PLANNER.plan(problem, None), PLANNER.plan(reordered(problem, order), None)
    assert np.abs(plain.inputs - other.inputs).max() < 1e-6
    assert plain.status is other.status
    assert np.array_equal(plain.memory.person_sides[order], other.memory.person_sides)


def reordered(problem, order):
    """The problem with its people in another order."""
    p, s, who = problem.predictions, problem.spaces, problem.people
    return dataclasses.replace(
        problem,
        people=dataclasses.replace(who, **taken(who, order, PERSON)),
        predictions=dataclasses.replace(p, **taken(p, order, PREDICTED)),
        spaces=dataclasses.replace(s, **taken(s, order, SPACE)),
    )


PERSON = ("id", "mean", "covariance", "heading", "radius", "confidence")
PREDICTED = ("weight", "mean", "velocity", "deviation")
SPACE = ("axis", "front", "side", "rear")


def taken(value, order, names):
    return {name: getattr(value, name)[order] for name in names}


def test_a_therapists_distance_is_added_to_the_clearance():
    """A standing person beside the path: passed 0.2 m farther away, where the clearance ends."""
    person = scene(people=walkers([[2.5, 0.75, 0.0, 0.0]]), speed=0.7)
    near = PLANNER.plan(person, None)
    far = PLANNER.plan(dataclasses.replace(person, extra_clearance=0.5), None)
    assert gaps(person, far.poses).min() > gaps(person, near.poses).min() + 0.02


def test_a_plan_that_is_not_a_stop_is_free_of_contact():
    """At its own steps while it moves, as far ahead as it was verified."""
    for seed in range(40):
        problem = drawn(seed, seed % 6)
        plan = PLANNER.plan(problem, None)
        if plan.status is Status.STOP:
            continue
        ahead = round(PLANNER.parameters.verification.horizon / STEP)
        moves = np.abs(plan.inputs[: ahead - 1]).max(axis=1) > STANDING
        assert gaps(problem, plan.poses)[:, 1:ahead][:, moves].min(initial=1.0) > 0.0
        centres = transform(plan.poses[:, None], problem.robot.discs[:, :2])
        clear = problem.walls.at(centres) - problem.robot.discs[:, 2]
        assert clear[:ahead].min() > 0.0


def test_a_stop_brakes_along_its_arc():
    """Deep in a crowd: the speed falls at the chair's braking, v/ω stays until both are 0."""
    around = np.array([[1.0, y, -0.3, 0.0] for y in (-0.9, -0.3, 0.3, 0.9)])
    plain = scene(people=walkers(around), speed=0.8)
    problem = dataclasses.replace(plain, twist=np.array([0.8, 0.0, 0.2]))
    plan = PLANNER.plan(problem, None)
    assert plan.status is Status.STOP
    assert plan.reason is Reason.NO_SAFE_PLAN
    speeds, turns = plan.inputs.T
    assert (np.diff(speeds) <= 1e-9).all()
    # 0.8 m/s at 1 m/s² is 0.8 s: five steps of 0.16 s, and one more for the half at the start
    stopped = int(np.ceil(0.8 / problem.robot.max_deceleration / STEP)) + 1
    assert speeds[stopped:].max() < 1e-9
    moving = speeds > 0.01
    assert turns[moving] == pytest.approx(0.25 * speeds[moving])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_standing_person_is_passed_on_the_free_side(side):
    """A hand's breadth left (right) of the path's centre: the chair goes by on the right (left)."""
    problem = scene(people=walkers([[3.0, 0.15 * side, 0.0, 0.0]]), speed=0.7)
    aside = PLANNER.plan(problem, None).poses[:, 1]
    assert aside[np.abs(aside).argmax()] * side < 0.0


def test_it_goes_backwards_only_where_that_is_wanted():
    """Someone strolls up to a chair that stands: backing off would be the cheapest answer."""
    problem = scene(people=walkers([[1.7, 0.0, -0.25, 0.0]]), wanted=0.0)
    assert PLANNER.plan(problem, None).inputs[:, 0].min() >= -1e-9
    allowed = PLANNER.plan(dataclasses.replace(problem, stalled=True, reverses=True), None)
    assert allowed.inputs[:, 0].min() < -0.05
    assert allowed.inputs[:, 0].min() >= -problem.robot.max_reverse_speed - 1e-9
    check_sound(allowed, problem)


def test_a_slower_limit_is_obeyed_at_once():
    problem = dataclasses.replace(scene(speed=0.8), speed_limit=0.3)
    plan = PLANNER.plan(problem, None)
    # the change to the first command must fit into a tick of 0.05 s, all later ones into a step
    fall = problem.robot.max_deceleration
    assert plan.inputs[0, 0] <= 0.8 - 0.99 * fall * TICK
    assert plan.inputs[-1, 0] <= 0.3 + 1e-6


@pytest.mark.parametrize("period", [0.04, 0.05, 0.08, 0.1])
def test_it_gathers_speed_whatever_the_period_of_its_commands(period):
    """At most as many commands as in time, and one or two more."""
    counts = {}
    for each in (0.05, period):
        plan, pose, twist, count = None, np.zeros(3), np.zeros(3), 0
        while twist[0] < 0.63 and count < 60:
            problem = local_problem(steps=PLANNER.steps, step=PLANNER.step, pose=pose, wanted=0.7)
            problem = dataclasses.replace(problem, time=each * count, twist=twist)
            plan = PLANNER.plan(problem, plan)
            twist, count = plan.command, count + 1
            pose = problem.robot.motion_model.rollout(pose, plan.inputs[:1], each)[-1]
        counts[each] = count
    assert counts[period] <= counts[0.05] + 2


def test_a_chair_at_its_goal_stays_there():
    problem = scene(speed=0.0, wanted=0.0)
    plan = PLANNER.plan(problem, None)
    assert np.abs(plan.inputs).max() < 1e-6


def test_the_social_space_is_kept_where_there_is_room():
    """An empty floor, someone beside the path: h ≥ 0 all along, with no slack."""
    person = walkers([[3.0, 1.4, 0.0, 0.0]])
    plan = PLANNER.plan(scene(people=person, speed=0.8), None)
    assert plan.status is Status.OK
    assert plan.smallest_barrier >= 0.0


def test_printed_spaces_are_planned_with_as_well():
    for seed in range(10):
        problem = drawn(seed, 4)
        model = PersonalSpace(PersonalSpace.Parameters(shape="printed"))
        spaces = model.spaces(
            problem.people,
            Groups.alone(4),
            problem.predictions,
            problem.twist,
            problem.profile,
        )
        printed = dataclasses.replace(problem, spaces=spaces)
        check_sound(PLANNER.plan(printed, None), printed)


def test_an_open_floor_has_no_edge_that_matters():
    here, there = scene(speed=0.5), scene(speed=0.5, walls=open_floor((-30.0, -11.0, 0.7)))
    assert identical(PLANNER.plan(here, None).inputs, PLANNER.plan(there, None).inputs)
