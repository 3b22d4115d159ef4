import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.control import OptimalControl, SsMpcDcbf, Trajectory, sqp
from cohelm.control.objective import trajectory_cost
from cohelm.control.stack import Terms
from cohelm.control.trajectories import limited_trajectory
from cohelm.robots import Robot
from cohelm.robots.clearance import Clearance
from cohelm.testing.problems import random_problem

PUSH = 1e-5


def wandering(problem, rng):
    """A random trajectory within the limits."""
    steps = len(problem.reference.speeds) - 1
    inputs = np.column_stack(
        [rng.uniform(-0.2, 1.0, steps), np.cumsum(rng.normal(0.0, 0.3, steps))]
    )
    if problem.robot.motion_model.inputs == 3:
        inputs = np.insert(inputs, 1, rng.uniform(-0.8, 0.8, steps), axis=1)
    return limited_trajectory(problem, inputs, problem.robot.motion_model.input(problem.twist))


def any_way(problem):
    """The same problem for a holonomic robot."""
    build = problem.robot.model_dump() | {"kinematics": "holonomic", "max_reverse_speed": 1.0}
    return dataclasses.replace(problem, robot=Robot(**build))


def standing(problem):
    """The trajectory of a robot that stands."""
    steps, step = len(problem.reference.speeds) - 1, problem.reference.step
    m = problem.robot.motion_model.inputs
    return Trajectory(
        step=step,
        poses=np.tile(problem.pose, (steps + 1, 1)),
        inputs=np.zeros((steps, m)),
        current_input=np.zeros(m),
    )


def prepared(problem, terms=None, current_input=None, **control):
    """The tables of a problem; by default with the terms and the clearance of the planner."""
    solver = OptimalControl(terms or Terms(), control.pop("clearance", Clearance()), **control)
    now = problem.robot.motion_model.input(problem.twist)
    return solver.prepare(problem, now if current_input is None else current_input)


def cost_of(tables, inputs):
    """The objective at inputs, s."""
    poses = np.empty((len(inputs) + 1, 3))
    return trajectory_cost(tables.scene, tables.objective, inputs, poses, tables.work)


def linearised(tables, inputs):
    """(workspace, number of rows) of the program at inputs."""
    space = tables.control.space(tables.scene, tables.objective, 4096)
    space.inputs[0][:] = inputs
    scene, objective = tables.scene, tables.objective
    trajectory_cost(scene, objective, space.inputs[0], space.poses[0], space.work)
    return space, sqp.linearise(scene, objective, space, space.inputs[0])


def slope(of, inputs):
    """d of(inputs)/du by central differences, (..., N·m)."""
    columns = []
    for column in range(inputs.size):
        push = np.zeros(inputs.shape)
        push.flat[column] = PUSH
        columns.append((of(inputs + push) - of(inputs - push)) / (2.0 * PUSH))
    return np.stack(columns, axis=-1)


@pytest.fixture(scope="session")
def motions():
    """Trajectories, and their costs with derivatives."""
    return SimpleNamespace(
        wandering=wandering,
        standing=standing,
        any_way=any_way,
        prepared=prepared,
        cost_of=cost_of,
        linearised=linearised,
        slope=slope,
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
