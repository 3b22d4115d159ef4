import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control import PathFollower, SsMpcDcbf, without_people
from cohelm.messages import GroupSpaces
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem


@pytest.mark.parametrize("people", [0, 3, 9])
def test_it_is_the_social_planner_with_nobody_there(people):
    problem = random_problem(np.random.default_rng(people), people).problem
    blind, alone = PathFollower(), without_people(problem)
    first = blind.plan(problem, None)
    assert identical(first, SsMpcDcbf().plan(alone, None))
    later = dataclasses.replace(problem, time=0.05)
    assert identical(
        blind.plan(later, first), SsMpcDcbf().plan(dataclasses.replace(alone, time=0.05), first)
    )


def test_a_group_on_the_path_is_not_seen_either():
    """The hull of somebody at (3, 0) with 1 m about it: s(u) = 3 cos φ + 1 in every direction."""
    alone = local_problem(steps=25, step=0.16, speed=0.8, wanted=0.8)
    direction = 2.0 * np.pi * np.arange(16) / 16
    support = np.broadcast_to(3.0 * np.cos(direction) + 1.0, (1, 26, 16))
    groups = GroupSpaces(id=np.array([0]), direction=direction, support=support)
    problem = dataclasses.replace(alone, spaces=dataclasses.replace(alone.spaces, groups=groups))
    assert identical(PathFollower().plan(problem, None), PathFollower().plan(alone, None))


def test_nobody_is_left_and_all_else_is(rng):
    problem = random_problem(rng, 4).problem
    alone = without_people(problem)
    assert len(alone.people) == len(alone.predictions.mean) == len(alone.spaces.axis) == 0
    assert alone.predictions.mean.shape == (0, *problem.predictions.mean.shape[1:])
    for name in ("reference", "walls", "pose", "twist", "robot", "profile", "speed_limit"):
        assert getattr(alone, name) is getattr(problem, name)


def test_its_parameters_are_those_of_the_social_planner():
    parameters = PathFollower.Parameters(steps=10, step=0.2, sampling={"horizon": 1.0})
    assert (PathFollower(parameters).steps, PathFollower(parameters).step) == (10, 0.2)
    assert PathFollower().parameters.model_dump() == SsMpcDcbf.Parameters().model_dump()
