import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.control import Motion, SsMpcDcbf
from cohelm.control.sqp import with_inputs
from cohelm.control.warm_start import limited_motion
from cohelm.robots import Robot
from cohelm.testing.problems import random_problem

PUSH = 1e-6


def wandering(problem, rng):
    """A motion that obeys the limits and goes anywhere."""
    steps = len(problem.reference.speeds) - 1
    inputs = np.column_stack(
        [rng.uniform(-0.2, 1.0, steps), np.cumsum(rng.normal(0.0, 0.3, steps))]
    )
    if problem.robot.motion.inputs == 3:
        inputs = np.insert(inputs, 1, rng.uniform(-0.8, 0.8, steps), axis=1)
    return limited_motion(problem, inputs, problem.robot.motion.input(problem.twist))


def any_way(problem):
    """The same problem for a robot of the same build that moves any way."""
    build = problem.robot.model_dump() | {"kinematics": "holonomic", "max_reverse_speed": 1.0}
    return dataclasses.replace(problem, robot=Robot(**build))


def slope(of, problem, motion):
    """d of(motion)/du by central differences, (q, N·m)."""
    columns = []
    for column in range(motion.inputs.size):
        push = np.zeros(motion.inputs.shape)
        push.flat[column] = PUSH
        ahead, behind = (
            of(with_inputs(problem, motion, motion.inputs + s * push)) for s in (1.0, -1.0)
        )
        columns.append((ahead - behind) / (2.0 * PUSH))
    return np.stack(columns, axis=-1)


def sensitivity(problem, motion):
    return problem.robot.motion.sensitivity(motion.poses, motion.inputs, motion.step)


def standing(problem):
    """The motion of a chair that stands."""
    steps, step = len(problem.reference.speeds) - 1, problem.reference.step
    m = problem.robot.motion.inputs
    return Motion(
        step=step,
        poses=np.tile(problem.pose, (steps + 1, 1)),
        inputs=np.zeros((steps, m)),
        last_input=np.zeros(m),
    )


@pytest.fixture(scope="session")
def motions():
    """CandidateTrajectories to move, and to differentiate by the inputs."""
    return SimpleNamespace(
        wandering=wandering,
        slope=slope,
        sensitivity=sensitivity,
        standing=standing,
        any_way=any_way,
    )


@pytest.fixture(scope="session")
def planner():
    return SsMpcDcbf()


@pytest.fixture(scope="session")
def crowded():
    """Twelve problems of up to ten people."""
    rng = np.random.default_rng(7)
    return [
        random_problem(rng, people).problem for people in (0, 1, 1, 2, 2, 3, 4, 5, 6, 8, 10, 10)
    ]
