import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf, Trajectory
from cohelm.control.trajectories import limited_trajectory
from cohelm.robots import Robot
from cohelm.testing.problems import random_problem

PUSH = 1e-6


def wandering(problem, rng):
    """A motion that obeys the limits and goes anywhere."""
    steps = len(problem.reference.speeds) - 1
    inputs = np.column_stack(
        [rng.uniform(-0.2, 1.0, steps), np.cumsum(rng.normal(0.0, 0.3, steps))]
    )
    if problem.robot.motion_model.inputs == 3:
        inputs = np.insert(inputs, 1, rng.uniform(-0.8, 0.8, steps), axis=1)
    return limited_trajectory(problem, inputs, problem.robot.motion_model.input(problem.twist))


def any_way(problem):
    """The same problem for a robot of the same build that moves any way."""
    build = problem.robot.model_dump() | {"kinematics": "holonomic", "max_reverse_speed": 1.0}
    return dataclasses.replace(problem, robot=Robot(**build))


def with_inputs(problem, trajectory, inputs):
    """The trajectory with other inputs (N, m)."""
    poses = problem.robot.motion_model.rollout(problem.pose, inputs, trajectory.step)
    return dataclasses.replace(trajectory, poses=poses, inputs=inputs)


def slope(of, problem, trajectory):
    """d of(motion)/du by central differences, (q, N·m)."""
    columns = []
    for column in range(trajectory.inputs.size):
        push = np.zeros(trajectory.inputs.shape)
        push.flat[column] = PUSH
        ahead, behind = (
            of(with_inputs(problem, trajectory, trajectory.inputs + s * push)) for s in (1.0, -1.0)
        )
        columns.append((ahead - behind) / (2.0 * PUSH))
    return np.stack(columns, axis=-1)


def sensitivity(problem, trajectory):
    return problem.robot.motion_model.sensitivity(
        trajectory.poses, trajectory.inputs, trajectory.step
    )


def standing(problem):
    """The motion of a chair that stands."""
    steps, step = len(problem.reference.speeds) - 1, problem.reference.step
    m = problem.robot.motion_model.inputs
    return Trajectory(
        step=step,
        poses=np.tile(problem.pose, (steps + 1, 1)),
        inputs=np.zeros((steps, m)),
        current_input=np.zeros(m),
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
