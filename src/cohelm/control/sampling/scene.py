"""Surroundings of the robot as plain arrays: path, people, groups, walls and the robot itself."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem
from cohelm.control.sampling.path_samples import PathSamples, path_samples
from cohelm.messages import GroupSpaces
from cohelm.robots.contact import WallGrid, wall_margins
from cohelm.shapes import PRINTED


class PersonHypotheses(NamedTuple):
    """People in each of their hypotheses, P pairs of person and hypothesis."""

    states: Floats
    """(P, N+1, 8): x, y, axis of motion (cos, sin), 1/2σ² ahead, behind and aside, deviation."""
    weight: Floats
    """(P,) probability."""
    radius: Floats
    """(P,) m."""
    fastest: Floats
    """(P,) m/s, over all steps."""
    scale: float
    """c of eq. (5)."""
    printed: bool
    """The extent of a space is c/q as printed, not √(c/q); see ``shapes``."""
    floor: float
    """Smallest extent of a space, m."""
    extent: float
    """Largest extent of any space, m."""


class GroupHulls(NamedTuple):
    """Convex hulls of groups, and discs about these."""

    support: Floats
    """(g, N+1, m)."""
    normal: Floats
    """(m, 2) unit vectors."""
    disc: Floats
    """(g, N+1, 3): centre and radius."""


class RolloutWalls(NamedTuple):
    """Distance to everything that is not a person."""

    grid: WallGrid
    margin: Floats
    """(c,) gap of each disc that counts as contact, m."""


class RobotState(NamedTuple):
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
    n_linear: int
    """Number of linear velocities in an input, see ``Kinematics.translating``; 2: holonomic."""
    top_speed: float
    """m/s."""
    capsule: Floats
    """(5,) as ``Robot.capsule``."""
    discs: Floats
    """(c, 3) as ``Robot.discs``."""
    outer_radius: float
    """Radius about the pose that holds the footprint, m."""


class RolloutScene(NamedTuple):
    """Everything that a rollout reads."""

    step: float
    """s."""
    steps: int
    """N."""
    heading_lead: float
    """Time for which the robot turns before the translation of a step, s: the kinematics' own, and
    more where a step replaces several of the planner's."""
    path: PathSamples
    people: PersonHypotheses
    groups: GroupHulls
    walls: RolloutWalls
    robot: RobotState


def rollout_scene(
    problem: LocalProblem, current_input: Floats, steps: int, wall_margin: float
) -> RolloutScene:
    """The problem over ``steps`` of its own, which may be more than it has.

    Beyond the end of the predictions people keep their last velocity.
    """
    step = problem.reference.step
    return RolloutScene(
        step=step,
        steps=steps,
        heading_lead=problem.robot.motion_model.turned * step,
        path=path_samples(problem.reference, problem.top_speed, steps),
        people=_people(problem, steps),
        groups=_group_hulls(problem.spaces.groups, steps),
        walls=_walls(problem, wall_margin),
        robot=_robot_state(problem, current_input),
    )


def coarser(scene: RolloutScene, stride: int) -> RolloutScene:
    """The scene with ``stride`` steps in one; ``scene.steps`` must be a multiple of it."""
    if stride == 1:
        return scene
    every = np.s_[::stride]
    people, groups, robot = scene.people, scene.groups, scene.robot
    return scene._replace(
        step=stride * scene.step,
        steps=scene.steps // stride,
        heading_lead=scene.heading_lead + 0.5 * (stride - 1) * scene.step,
        path=scene.path._replace(reference=scene.path.reference[every].copy()),
        people=people._replace(states=people.states[:, every].copy()),
        groups=groups._replace(
            support=groups.support[:, every].copy(), disc=groups.disc[:, every].copy()
        ),
        robot=robot._replace(rise=stride * robot.rise, fall=stride * robot.fall),
    )


def _people(problem: LocalProblem, steps: int) -> PersonHypotheses:
    p, s = problem.predictions, problem.spaces
    weight, radius, fastest, front = _by_hypothesis(
        p.weight, problem.people.radius, p.velocity, s.front
    )
    printed = s.kind == PRINTED
    extent = 2.0 * s.scale * front**2 if printed else math.sqrt(2.0 * s.scale) * front
    return PersonHypotheses(
        states=_person_states(
            p.mean, p.velocity, p.deviation, (s.axis, s.front, s.side, s.rear), steps, p.step
        ),
        weight=weight,
        radius=radius,
        fastest=fastest,
        scale=s.scale,
        printed=printed,
        floor=s.floor,
        extent=max(extent, s.floor),
    )


@njit(cache=True)
def _by_hypothesis(
    weight: Floats, radius: Floats, velocity: Floats, front: Floats
) -> tuple[Floats, Floats, Floats, float]:
    """(weight, radius, fastest (P,) of ``PersonHypotheses``; the largest value of ``front``)."""
    n, h, states = front.shape
    weights, radii, fastest, largest = np.empty(n * h), np.empty(n * h), np.zeros(n * h), 0.0
    for i in range(n):
        for j in range(h):
            weights[i * h + j], radii[i * h + j] = weight[i, j], radius[i]
            for k in range(velocity.shape[2]):
                speed = math.hypot(velocity[i, j, k, 0], velocity[i, j, k, 1])
                fastest[i * h + j] = max(fastest[i * h + j], speed)
            for k in range(states):
                largest = max(largest, front[i, j, k])
    return weights, radii, fastest, largest


@njit(cache=True)
def _person_states(
    mean: Floats,
    velocity: Floats,
    deviation: Floats,
    spaces: tuple[Floats, Floats, Floats, Floats],
    steps: int,
    step: float,
) -> Floats:
    """States of ``PersonHypotheses``; spaces: (axis, front, side, rear) of ``SocialSpaces``."""
    axis, front, side, rear = spaces
    n, h, known = mean.shape[0], mean.shape[1], mean.shape[2]
    out = np.empty((n * h, steps + 1, 8))
    for i in range(n):
        for j in range(h):
            row = out[i * h + j]
            for k in range(steps + 1):
                m = min(k, known - 1)
                rest = (k - m) * step
                vx, vy = velocity[i, j, m, 0], velocity[i, j, m, 1]
                row[k, 0] = mean[i, j, m, 0] + rest * vx
                row[k, 1] = mean[i, j, m, 1] + rest * vy
                row[k, 2], row[k, 3] = np.cos(axis[i, j, m]), np.sin(axis[i, j, m])
                row[k, 4] = 0.5 / front[i, j, m] ** 2
                row[k, 5] = 0.5 / rear[i, j, m] ** 2
                row[k, 6] = 0.5 / side[i, j, m] ** 2
                row[k, 7] = deviation[i, j, m]
    return out


def _group_hulls(groups: GroupSpaces | None, steps: int) -> GroupHulls:
    """The hulls over ``steps``; beyond the known steps they continue their last motion."""
    if groups is None or not len(groups.id):
        return GroupHulls(np.empty((0, 1, 1)), np.empty((0, 2)), np.empty((0, 1, 3)))
    normal = _unit_vectors(tuple(groups.direction.tolist()))
    support, centre = _centred(groups.support, normal, steps)
    radius = (support - centre @ normal.T).max(axis=2)
    return GroupHulls(support, normal, np.concatenate([centre, radius[..., None]], axis=-1))


@functools.lru_cache(maxsize=8)
def _unit_vectors(directions: tuple[float, ...]) -> Floats:
    """(m, 2)."""
    return np.stack([np.cos(directions), np.sin(directions)], axis=-1)


@njit(cache=True)
def _centred(known: Floats, normal: Floats, steps: int) -> tuple[Floats, Floats]:
    """(support (g, N+1, m), a point (g, N+1, 2) inside) of hulls known for some steps.

    Twice the mean of s(u) u is the centre of a disc, and lies inside any hull.
    """
    groups, states, m = known.shape
    support, centre = np.empty((groups, steps + 1, m)), np.zeros((groups, steps + 1, 2))
    for g in range(groups):
        for k in range(steps + 1):
            last, beyond = min(k, states - 1), max(k - states + 1, 0)
            for j in range(m):
                extent = known[g, last, j]
                if states > 1 and steps >= states:
                    extent += beyond * (known[g, -1, j] - known[g, -2, j])
                support[g, k, j] = extent
                centre[g, k, 0] += extent * normal[j, 0]
                centre[g, k, 1] += extent * normal[j, 1]
            for a in range(2):
                centre[g, k, a] = 2.0 * (centre[g, k, a] / m)
    return support, centre


def _walls(problem: LocalProblem, margin: float) -> RolloutWalls:
    walls = problem.walls
    grid = WallGrid(np.ascontiguousarray(walls.distance), walls.resolution, walls.X_MG)
    return RolloutWalls(grid, wall_margins(problem.robot.discs, problem.pose, grid, margin))


def _robot_state(problem: LocalProblem, current_input: Floats) -> RobotState:
    robot, step = problem.robot, problem.reference.step
    low, high, rise, fall = problem.input_bounds()
    discs = robot.discs
    return RobotState(
        start=problem.pose.copy(),
        current_input=np.array(current_input, dtype=float),
        low=low,
        high=high,
        rise=rise * step,
        fall=fall * step,
        n_linear=robot.motion_model.translating,
        top_speed=problem.top_speed,
        capsule=robot.capsule.copy(),
        discs=discs.copy(),
        outer_radius=max(math.hypot(x, y) + radius for x, y, radius in discs.tolist()),
    )
