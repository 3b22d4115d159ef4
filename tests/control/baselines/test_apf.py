import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control.baselines import Apf
from cohelm.control.baselines.apf import PotentialField, people_force, repulsion, walls_force
from cohelm.maps import distance_field
from cohelm.messages import Authority, Status
from cohelm.robots import load_robot
from cohelm.robots.wall_contact import wall_grid
from cohelm.testing.problems import field_of, mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, open_floor, room, straight_on, walkers

PLANNER = Apf()
P = PLANNER.parameters
CHAIR = load_robot("quantum_q6_edge")


def scene(**options):
    return local_problem(steps=P.steps, step=P.step, **options)


def pushed(problem, forward, left, eta=0.63):
    deflection = np.array([forward, left])
    hand = Authority(
        eta=eta, intent=1.0, deflection=deflection, twist=np.zeros(3), states=problem.reference
    )
    return dataclasses.replace(problem, authority=hand)


def field(people=(), walls=None, **strengths):
    return PotentialField(
        goals=np.empty((0, 2)),
        speeds=np.empty(0),
        stick=np.zeros(2),
        eta=0.0,
        capsule=CHAIR.capsule,
        discs=CHAIR.discs,
        positions=np.reshape(people, (-1, 2)),
        radius=np.full(len(people), 0.25),
        walls=wall_grid(open_floor() if walls is None else walls),
        **{
            "people_range": 2.0,
            "people_strength": 0.3,
            "wall_range": 0.5,
            "wall_strength": 0.01,
            **strengths,
        },
    )


def test_repulsion_by_hand():
    """η (1/ρ − 1/ρ₀) / ρ²: 0.1 · (2 − 1) / 0.25."""
    assert repulsion(0.5, 1.0, 0.1) == pytest.approx(0.4)


def test_repulsion_falls_with_distance_vanishes_beyond_its_reach_and_stays_finite():
    sizes = [repulsion(gap, 1.0, 0.1) for gap in np.linspace(0.05, 1.2, 50)]
    assert (np.diff(sizes) <= 0.0).all()
    assert repulsion(1.0, 1.0, 0.1) == repulsion(3.0, 1.0, 0.1) == 0.0
    assert repulsion(-0.3, 1.0, 0.1) == repulsion(0.0, 1.0, 0.1) == repulsion(0.05, 1.0, 0.1)


@pytest.mark.parametrize("direction", np.linspace(-3.0, 3.0, 7))
def test_people_push_away(direction):
    """From the spine's nearest point; sideways of it that is straight away."""
    person = np.array([[0.1, 0.0]]) + 1.2 * np.array([[np.cos(direction), np.sin(direction)]])
    force = people_force(np.zeros(3), field(person))
    ends = CHAIR.capsule[[0, 2]]
    away = np.array([np.clip(person[0, 0], ends.min(), ends.max()), 0.0]) - person[0]
    assert np.dot(force, away) > 0.0
    assert force[0] * away[1] - force[1] * away[0] == pytest.approx(0.0, abs=1e-3)


def test_walls_push_along_the_gradient():
    """A wall to the left, half a plane: the push is to the right and nothing else."""
    plane = np.array([[0.0, -1.0, -0.6]])  # free where y < 0.6
    x, y = walls_force(np.zeros(3), field(walls=field_of(plane, np.zeros(3))))
    gap = 0.6 - CHAIR.discs[0, 1] - CHAIR.discs[0, 2]
    assert x == pytest.approx(0.0, abs=1e-6)
    assert y == pytest.approx(-repulsion(gap, 0.5, 0.01), rel=1e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_push_to_the_left_turns_left(side):
    problem = pushed(scene(speed=0.5), 0.5, 0.8 * side)
    assert PLANNER.plan(problem, None).command[2] * side > 0.05


def test_the_hand_counts_by_its_authority():
    turns = [
        PLANNER.plan(pushed(scene(speed=0.5), 0.5, 0.3, eta=eta), None).poses[-1, 2]
        for eta in (0.0, 0.3, 0.6, 0.9)
    ]
    assert turns[0] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(turns) > 0.0).all()


def test_nothing_near_follows_the_path():
    plan = PLANNER.plan(scene(speed=0.5), None)
    assert plan.command[2] == pytest.approx(0.0, abs=1e-9)
    assert plan.costs["path"] == pytest.approx(1.0)
    assert plan.costs["people"] == plan.costs["walls"] == plan.costs["rider"] == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_leans_away_from_who_stands_beside_the_path(side):
    problem = scene(people=walkers([[1.8, 0.6 * side, 0.0, 0.0]]), speed=0.5)
    assert PLANNER.plan(problem, None).command[2] * side < 0.0


def test_it_does_not_know_where_people_go():
    people = walkers([[2.0, 0.5, 0.3, -0.8], [3.0, -1.0, 0.0, 1.0]])
    problem = scene(people=people, speed=0.5)
    still = straight_on(walkers(people.mean * [1.0, 1.0, 0.0, 0.0]), P.steps, P.step)
    other = dataclasses.replace(problem, predictions=still)
    assert identical(PLANNER.plan(problem, None), PLANNER.plan(other, None))


def test_it_stands_in_a_local_minimum_and_says_so():
    """Somebody straight ahead on the path: once the forces cancel nothing moves it on."""
    problem = scene(people=walkers([[1.4, 0.0, 0.0, 0.0]]))
    plan = PLANNER.plan(problem, None)
    assert plan.status is Status.STOP
    assert plan.reason is not None
    assert np.abs(plan.command).max() < 1e-6


def test_it_does_not_drive_into_a_wall():
    grid = room(boxes=[(6.0, 0.0, 6.4, 8.0)])
    problem = scene(pose=(4.6, 4.0, 0.0), speed=0.6, walls=distance_field(grid))
    plan, pose, twist = None, problem.pose, problem.twist
    for k in range(80):
        here = dataclasses.replace(problem, time=0.05 * k, pose=pose, twist=twist)
        plan = PLANNER.plan(here, plan)
        twist = plan.command
        pose = CHAIR.motion_model.rollout(pose, CHAIR.motion_model.input(twist)[None], 0.05)[-1]
    assert pose[0] + 0.65 < 6.0
    assert abs(twist[0]) < 0.05


@pytest.mark.parametrize("seed", range(4))
def test_turned_and_mirrored_worlds_have_turned_and_mirrored_plans(seed):
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 3, steps=P.steps, step=P.step).problem
    plain = PLANNER.plan(problem, None)
    other = PLANNER.plan(turned(problem, np.array([3.0, -7.0, 0.4])), None)
    assert np.abs(plain.command - other.command).max() < 1e-6
    flipped = PLANNER.plan(mirrored(problem), None)
    assert np.abs(plain.command - flipped.command * [1.0, 1.0, -1.0]).max() < 1e-6
