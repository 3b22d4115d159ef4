import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control import PathFollower, SsMpcDcbf, without_people
from cohelm.testing.problems import random_problem


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


def test_nobody_is_left_and_all_else_is(rng):
    problem = random_problem(rng, 4).problem
    alone = without_people(problem)
    assert len(alone.people) == len(alone.predictions.mean) == len(alone.spaces.axis) == 0
    assert alone.predictions.mean.shape == (0, *problem.predictions.mean.shape[1:])
    for name in ("reference", "walls", "pose", "twist", "robot", "profile", "speed_limit"):
        assert getattr(alone, name) is getattr(problem, name)


def test_its_parameters_are_those_of_the_social_planner():
    parameters = PathFollower.Parameters(steps=10, step=0.2, lookahead=0.0)
    assert (PathFollower(parameters).steps, PathFollower(parameters).step) == (10, 0.2)
    assert PathFollower().parameters.model_dump() == SsMpcDcbf.Parameters().model_dump()
