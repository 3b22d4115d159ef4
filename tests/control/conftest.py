from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.control import Motion, SsMpcDcbf
from cohelm.control.sqp import moved
from cohelm.control.warm_start import followed
from cohelm.testing.problems import random_problem

PUSH = 1e-6


def wandering(problem, rng):
    """A motion that obeys the limits and goes anywhere."""
    steps = len(problem.reference.speeds) - 1
    inputs = np.column_stack(
        [rng.uniform(-0.2, 1.0, steps), np.cumsum(rng.normal(0.0, 0.3, steps))]
    )
    return followed(problem, inputs, problem.twist[[0, 2]])


def slope(of, problem, motion):
    """d of(motion)/du by central differences, (q, N·m)."""
    columns = []
    for column in range(motion.inputs.size):
        push = np.zeros(motion.inputs.shape)
        push.flat[column] = PUSH
        ahead, behind = (of(moved(problem, motion, motion.inputs + s * push)) for s in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * PUSH))
    return np.stack(columns, axis=-1)


def sensitivity(problem, motion):
    return problem.robot.motion.sensitivity(motion.poses, motion.inputs, motion.step)


def standing(problem):
    """The motion of a chair that stands."""
    steps, step = len(problem.reference.speeds) - 1, problem.reference.step
    return Motion(
        step=step,
        poses=np.tile(problem.pose, (steps + 1, 1)),
        inputs=np.zeros((steps, 2)),
        last_input=np.zeros(2),
    )


@pytest.fixture(scope="session")
def motions():
    """Ways to move, and to differentiate by the inputs."""
    return SimpleNamespace(
        wandering=wandering, slope=slope, sensitivity=sensitivity, standing=standing
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
