import dataclasses

import numpy as np
import pytest

from cohelm.control.baselines import SocialMpc
from cohelm.control.baselines.social_mpc import passing, social_cost
from cohelm.maps import distance_field
from cohelm.messages import Status
from cohelm.robots import load_robot
from cohelm.testing.problems import random_problem, turned
from cohelm.testing.scenes import local_problem, room, walkers

PLANNER = SocialMpc()
P = PLANNER.parameters
CHAIR = load_robot("quantum_q6_edge")
SIGMA = np.array([1.0, 0.66, 0.33, 1.0])


def scene(**options):
    return local_problem(steps=P.steps, step=P.step, **options)


def test_horizon_and_gaussians_are_those_of_poddar():
    assert PLANNER.rolled * P.step == pytest.approx(1.2)
    assert (P.front, P.side, P.rear) == (1.0, 0.66, 0.33)


def test_every_heading_at_every_speed_and_the_way_to_the_goal():
    problem = scene(speed=0.5)
    ways = PLANNER.rollouts(problem, np.array([0.5, 0.0]))
    assert len(ways.poses) == (P.headings + 1) * P.speeds
    fan = np.unique(np.round(ways.direction[: -P.speeds], 9))
    assert np.diff(fan) == pytest.approx(2.0 * np.pi / P.headings, abs=1e-8)
    assert ways.direction[-1] == pytest.approx(0.0, abs=1e-12)
    # wanted 0.8 m/s in quarters: 1, 2/3, 1/3, 0
    assert np.unique(np.round(ways.speed, 9)) == pytest.approx([0.0, 0.8 / 3, 1.6 / 3, 0.8])


@pytest.mark.parametrize("seed", range(3))
def test_rollouts_keep_the_limits_and_are_what_their_inputs_lead_to(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 2, steps=P.steps, step=P.step).problem
    now = problem.robot.motion_model.input(problem.twist)
    ways = PLANNER.rollouts(problem, now)
    low, high, rise, fall = problem.input_bounds()
    assert (ways.inputs[:, -1] <= high + 1e-9).all()
    assert (ways.inputs[:, -1] >= low - 1e-9).all()
    before = np.concatenate([np.tile(now, (len(ways.inputs), 1, 1)), ways.inputs[:, :-1]], axis=1)
    change = (ways.inputs - before) / P.step
    assert (change <= rise + 1e-9).all()
    assert (change >= -fall - 1e-9).all()
    for poses, inputs in list(zip(ways.poses, ways.inputs, strict=True))[::7]:
        assert poses == pytest.approx(CHAIR.motion_model.rollout(problem.pose, inputs, P.step))


@pytest.mark.parametrize(
    ("velocity", "sigma"),
    [((-1.0, 0.0), 1.0), ((1.0, 0.0), 0.33), ((0.0, 1.0), 0.66), ((0.0, 0.0), 1.0)],
    ids=["comes", "goes", "crosses", "stands"],
)
def test_a_gaussian_by_hand(velocity, sigma):
    """A body 0.5 m ahead of the footprint that walks at the chair, away, across, or stands."""
    ahead = CHAIR.capsule[2] + CHAIR.capsule[4] + 0.25 + 0.5
    poses = np.zeros((1, 2, 3))
    cost = social_cost(
        poses,
        CHAIR.capsule,
        np.tile([ahead, CHAIR.capsule[3]], (1, 1, 2, 1)),
        np.tile(velocity, (1, 1, 2, 1)),
        np.ones((1, 1)),
        np.array([0.25]),
        SIGMA,
    )
    assert cost == pytest.approx(np.exp(-0.5 * (0.5 / sigma) ** 2), rel=1e-4)


def test_futures_count_by_their_probability():
    positions = np.array([[[[2.0, 0.0]] * 2, [[50.0, 0.0]] * 2]])
    arguments = (np.zeros((1, 2, 3)), CHAIR.capsule, positions, np.zeros_like(positions))
    certain = social_cost(*arguments, np.array([[1.0, 0.0]]), np.array([0.25]), SIGMA)
    half = social_cost(*arguments, np.array([[0.5, 0.5]]), np.array([0.25]), SIGMA)
    assert half == pytest.approx(0.5 * certain)


def test_getting_round_somebody_is_an_angle():
    """From 1 m before a person who comes to 1 m beside: a quarter turn in one step."""
    poses = np.array([[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]])
    person = np.tile([1.0, 0.0], (1, 1, 2, 1))
    for velocity, turned_by in (((-1.0, 0.0), np.pi / 2), ((1.0, 0.0), 0.0)):
        angle = passing(poses, person, np.tile(velocity, (1, 1, 2, 1)), np.ones((1, 1)))
        assert angle == pytest.approx(turned_by)  # only those one is ahead of count


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_passes_on_the_free_side(side):
    problem = scene(people=walkers([[2.0, 0.5 * side, -0.8, 0.0]]), speed=0.8)
    plan = PLANNER.plan(problem, None)
    assert plan.command[2] * side < 0.0


def test_a_person_far_away_changes_nothing():
    alone = PLANNER.plan(scene(speed=0.5), None)
    far = PLANNER.plan(scene(speed=0.5, people=walkers([[-40.0, 30.0, 0.5, 0.0]])), None)
    assert far.inputs == pytest.approx(alone.inputs)


def test_where_every_rollout_touches_a_wall_it_brakes():
    """A cell of the chair's own size, entered at speed."""
    grid = room(boxes=[(0.0, 0.0, 12.0, 3.6), (0.0, 4.4, 12.0, 8.0), (4.95, 0.0, 6.0, 8.0)])
    problem = scene(pose=(4.2, 4.0, 0.0), speed=1.0, walls=distance_field(grid))
    plan = PLANNER.plan(problem, None)
    assert plan.status is Status.STOP
    assert plan.reason is not None
    assert plan.command[0] < 1.0


@pytest.mark.parametrize("seed", range(4))
def test_turning_the_world_turns_the_command(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 3, steps=P.steps, step=P.step).problem
    plain = PLANNER.plan(problem, None)
    other = PLANNER.plan(turned(problem, np.array([3.0, -7.0, 0.4])), None)
    assert np.abs(plain.command - other.command).max() < 1e-6


def test_it_gets_past_who_stands_on_the_path():
    """Straight ahead, 4 m away: whoever must turn first has to begin early."""
    plan, pose, twist = None, np.zeros(3), np.zeros(3)
    people = walkers([[4.0, 0.2, 0.0, 0.0]])
    for k in range(110):
        path = scene(people=people, pose=(pose[0], 0.0, 0.0))
        problem = dataclasses.replace(path, pose=pose, twist=twist, time=0.1 * k)
        plan = PLANNER.plan(problem, plan)
        twist = plan.command
        pose = CHAIR.motion_model.rollout(pose, CHAIR.motion_model.input(twist)[None], 0.1)[-1]
        if pose[0] > 5.5:
            break
    assert pose[0] > 5.5
