"""Surroundings of the robot as tables: path, people, groups, walls and the robot itself.

A scene is made once a tick from a ``LocalProblem``; all terms and barriers read it. Its horizon of
L steps may exceed the problem's own; the first N of them are planned.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem
from cohelm.control.path import PathTable, path_table
from cohelm.control.people_table import PeopleTable, people_table
from cohelm.control.trajectories import PLANNED_BRAKING
from cohelm.kernels import CACHED
from cohelm.messages import GroupSpaces
from cohelm.robots.clearance import Clearance
from cohelm.robots.wall_contact import WallGrid, wall_margins

_ROUNDING = 1e-6
"""m/s."""


class GroupTable(NamedTuple):
    """Convex hulls of groups, and discs about these."""

    support: Floats
    """(g, L+1, d) maximum of p·n over the hull for each direction n, m."""
    normal: Floats
    """(d, 2) unit vectors outwards."""
    disc: Floats
    """(g, L+1, 3): centre and radius."""


class WallTable(NamedTuple):
    """Distance to everything that is not a person."""

    grid: WallGrid
    margin: Floats
    """(c,) gap of each disc that counts as contact, m."""
    clearance: float
    """Gap that the rider wants, m."""


class RobotTable(NamedTuple):
    """State, limits and footprint of the robot."""

    start: Floats
    """(3,) pose."""
    current_input: Floats
    """u_{−1}, (m,)."""
    low: Floats
    """(m,) lowest input."""
    high: Floats
    """(m,) highest input."""
    rise: Floats
    """(m,) largest increase in a step."""
    fall: Floats
    """(m,) largest decrease in a step."""
    first_rise: Floats
    """(m,) largest increase until the next decision."""
    first_fall: Floats
    """(m,) largest decrease until the next decision."""
    acceleration: float
    """Present linear acceleration, m/s²."""
    jerk: float
    """Largest change of the linear acceleration, m/s³; +inf: no limit, as for a holonomic robot."""
    tick: float
    """Time until the next decision, s."""
    n_linear: int
    """Number of linear velocities in an input, see ``Kinematics.translating``; 2: holonomic."""
    top_speed: float
    """m/s."""
    facets: Floats
    """(f, m) as ``Kinematics.facets``."""
    capsule: Floats
    """(5,) as ``Robot.capsule``."""
    discs: Floats
    """(c, 3) as ``Robot.discs``."""
    outer_radius: float
    """Radius about the pose that holds the footprint, m."""


class Scene(NamedTuple):
    """Everything that terms, barriers and rollouts read."""

    step: float
    """s."""
    steps: int
    """L."""
    planned: int
    """N, steps that the SQP changes; barriers hold over these."""
    heading_lead: float
    """Time for which the robot turns before the translation of a step, s: the kinematics' own, and
    more where a step replaces several of the planner's."""
    path: PathTable
    people: PeopleTable
    groups: GroupTable
    walls: WallTable
    robot: RobotTable


class SceneSettings(NamedTuple):
    """Parameters of a scene."""

    steps: int
    """L."""
    planned: int
    """N."""
    clearance: Clearance
    wall_margin: float
    """Gap to a wall that counts as contact, m."""
    tick: float
    """Time until the next decision, s."""
    acceleration: float
    """Present linear acceleration, m/s²."""


def make_scene(problem: LocalProblem, current_input: Floats, settings: SceneSettings) -> Scene:
    """The tables of a problem.

    Beyond the end of the predictions people keep their last velocity.

    Args:
        problem: the problem.
        current_input: u_{−1}, (m,).
        settings: horizon, clearance and margins.
    """
    step = problem.reference.step
    return Scene(
        step=step,
        steps=settings.steps,
        planned=settings.planned,
        heading_lead=problem.robot.motion_model.turned * step,
        path=path_table(problem.reference, problem.top_speed, settings.steps),
        people=people_table(problem, settings.steps, settings.clearance),
        groups=_groups(problem.spaces.groups, settings.steps),
        walls=_walls(problem, settings.wall_margin),
        robot=_robot(problem, current_input, settings),
    )


def coarser(scene: Scene, stride: int) -> Scene:
    """The scene with ``stride`` steps in one; ``scene.steps`` must be a multiple of it."""
    if stride == 1:
        return scene
    every = np.s_[::stride]
    people, groups, robot = scene.people, scene.groups, scene.robot
    path = scene.path
    return scene._replace(
        step=stride * scene.step,
        steps=scene.steps // stride,
        planned=scene.planned // stride,
        heading_lead=scene.heading_lead + 0.5 * (stride - 1) * scene.step,
        path=path._replace(
            reference=path.reference[every].copy(),
            poses=path.poses[every].copy(),
            speeds=path.speeds[every].copy(),
        ),
        people=people._replace(
            states=people.states[:, every].copy(), fade=people.fade[every].copy()
        ),
        groups=groups._replace(
            support=groups.support[:, every].copy(), disc=groups.disc[:, every].copy()
        ),
        robot=robot._replace(rise=stride * robot.rise, fall=stride * robot.fall),
    )


def _groups(groups: GroupSpaces | None, steps: int) -> GroupTable:
    """The hulls over ``steps``; beyond the known steps they continue their last motion."""
    if groups is None or not len(groups.id):
        return GroupTable(np.empty((0, 1, 1)), np.empty((0, 2)), np.empty((0, 1, 3)))
    normal = _unit_vectors(tuple(groups.direction.tolist()))
    support, disc = _hulls(np.ascontiguousarray(groups.support), normal, steps)
    return GroupTable(support, normal, disc)


@functools.lru_cache(maxsize=8)
def _unit_vectors(directions: tuple[float, ...]) -> Floats:
    """(m, 2)."""
    return np.stack([np.cos(directions), np.sin(directions)], axis=-1)


@njit(**CACHED)
def _hulls(known: Floats, normal: Floats, steps: int) -> tuple[Floats, Floats]:
    """(support (g, L+1, m), containing discs (g, L+1, 3)) of hulls known for some steps.

    Twice the mean of s(u) u is the centre of a disc, and lies inside any hull.
    """
    groups, states, m = known.shape
    support, disc = np.empty((groups, steps + 1, m)), np.zeros((groups, steps + 1, 3))
    for g in range(groups):
        for k in range(steps + 1):
            last, beyond = min(k, states - 1), max(k - states + 1, 0)
            x, y, radius = 0.0, 0.0, 0.0
            for j in range(m):
                extent = known[g, last, j]
                if states > 1 and steps >= states:
                    extent += beyond * (known[g, -1, j] - known[g, -2, j])
                support[g, k, j] = extent
                x += 2.0 * extent * normal[j, 0] / m
                y += 2.0 * extent * normal[j, 1] / m
            for j in range(m):
                radius = max(radius, support[g, k, j] - x * normal[j, 0] - y * normal[j, 1])
            disc[g, k, 0], disc[g, k, 1], disc[g, k, 2] = x, y, radius
    return support, disc


def _walls(problem: LocalProblem, margin: float) -> WallTable:
    walls = problem.walls
    grid = WallGrid(np.ascontiguousarray(walls.distance), walls.resolution, walls.X_MG)
    margins = wall_margins(problem.robot.discs, problem.pose, grid, margin)
    return WallTable(grid, margins, problem.profile.clearance)


def _robot(problem: LocalProblem, current_input: Floats, settings: SceneSettings) -> RobotTable:
    robot, step, tick = problem.robot, problem.reference.step, settings.tick
    low, high, rise, fall = problem.input_bounds()
    jerk, too_fast = math.inf, bool(current_input[0] > high[0] + _ROUNDING)
    if robot.motion_model.translating == 1 and not too_fast:  # a lowered limit holds at once
        fall, jerk = fall * np.array([PLANNED_BRAKING, 1.0]), robot.max_jerk
    discs = robot.discs
    return RobotTable(
        start=np.array(problem.pose, dtype=float),
        current_input=np.array(current_input, dtype=float),
        low=low,
        high=high,
        rise=rise * step,
        fall=fall * step,
        first_rise=rise * tick,
        first_fall=fall * tick,
        acceleration=settings.acceleration,
        jerk=jerk,
        tick=tick,
        n_linear=robot.motion_model.translating,
        top_speed=problem.top_speed,
        facets=np.array(robot.motion_model.facets, dtype=float),
        capsule=robot.capsule.copy(),
        discs=discs.copy(),
        outer_radius=max(math.hypot(x, y) + radius for x, y, radius in discs.tolist()),
    )
