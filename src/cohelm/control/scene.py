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

from cohelm.arrays import Floats, Integers
from cohelm.control.api import LocalProblem
from cohelm.control.path import PathTable, path_table
from cohelm.messages import GroupSpaces
from cohelm.robots.clearance import Clearance, oncoming_share, people_margins
from cohelm.robots.contact import WallGrid, wall_margins
from cohelm.shapes import ELLIPSE, PRINTED

X, Y, AXIS_X, AXIS_Y, AHEAD, BEHIND, ASIDE, MARGIN = range(8)
"""Columns of ``PeopleTable.states``."""

_PLANNED_BRAKING = 0.75
"""Share of the comfort deceleration that is planned with; the rest is for what is not foreseen."""


class PeopleTable(NamedTuple):
    """People in each of their hypotheses, P pairs of person and hypothesis."""

    states: Floats
    """(P, L+1, 8): position, unit vector of the axis of motion, factors of cos² ahead, cos² behind
    and sin² in 1/l² of the personal space (1/l as printed), clearance."""
    weight: Floats
    """(P,) probability."""
    radius: Floats
    """(P,) m."""
    person: Integers
    """(P,) index of the person."""
    fastest: Floats
    """(P,) m/s, over all steps."""
    fade: Floats
    """(L+1,) weight of a prediction by its age."""
    count: int  # type: ignore[assignment]  # tuple.count is never used
    """Number of people."""
    printed: bool
    """The extent of a space is c/q as printed, not √(c/q); see ``shapes``."""
    floor: float
    """Smallest extent of a space, m."""
    extent: float
    """Largest extent of any person's space, m."""
    largest_margin: float
    """m."""
    own: Floats
    """(3,) factors as in ``states``, of the robot's own space."""
    own_floor: float
    """Smallest extent of that space, m."""
    own_extent: float
    """Largest extent of that space, m."""


class GroupTable(NamedTuple):
    """Convex hulls of groups, and discs about these."""

    support: Floats
    """(g, L+1, m)."""
    normal: Floats
    """(m, 2) unit vectors."""
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
    decay_time: float
    """Time constant with which the weight of predictions decays, s."""
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
        people=_people(problem, settings),
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


def _people(problem: LocalProblem, settings: SceneSettings) -> PeopleTable:
    """The people over L steps with their clearance."""
    p, s, steps = problem.predictions, problem.spaces, settings.steps
    law = settings.clearance.law(
        tight=problem.stalled,
        oncoming=oncoming_share(problem.people, problem.pose),
        extra=problem.extra_clearance,
    )
    margin = people_margins(p.velocity, p.deviation, p.step, steps, law)
    states, weight, radius, person, fastest = _person_states(
        p.mean,
        p.velocity,
        p.weight,
        problem.people.radius,
        margin,
        (s.axis, s.front, s.side, s.rear),
        s.kind,
        s.scale,
        p.step,
    )
    own, own_extent = _own_space(s.kind, s.scale, tuple(s.robot.tolist()), s.robot_floor)
    printed = s.kind == PRINTED
    widest = _widest(s.front, s.side, s.rear)
    extent = 2.0 * s.scale * widest**2 if printed else math.sqrt(2.0 * s.scale) * widest
    return PeopleTable(
        states=states,
        weight=weight,
        radius=radius,
        person=person,
        fastest=fastest,
        fade=_fade(problem.reference.step, steps, settings.decay_time),
        count=len(problem.people),
        printed=printed,
        floor=s.floor,
        extent=max(extent, s.floor) if len(problem.people) else 0.0,
        largest_margin=law.upper,
        own=own,
        own_floor=s.robot_floor,
        own_extent=own_extent,
    )


@functools.lru_cache(maxsize=64)
def _fade(step: float, steps: int, decay: float) -> Floats:
    """exp(−t / decay), (L+1,)."""
    return np.asarray(np.exp(-step * np.arange(steps + 1) / decay))


@functools.lru_cache(maxsize=64)
def _own_space(
    kind: int, scale: float, sigma: tuple[float, float, float], floor: float
) -> tuple[Floats, float]:
    """(factors (3,) of the robot's own space, its largest extent)."""
    front, side, rear = sigma
    rear = front if kind == ELLIPSE else rear
    factors = np.array([0.5 / (scale * each * each) for each in (front, rear, side)])
    widest = max(front, side, rear)
    extent = 2.0 * scale * widest**2 if kind == PRINTED else math.sqrt(2.0 * scale) * widest
    return factors, max(extent, floor)


@njit(cache=True)
def _widest(front: Floats, side: Floats, rear: Floats) -> float:
    """Largest of all σ."""
    largest = 0.0
    for i in range(front.shape[0]):
        for j in range(front.shape[1]):
            for k in range(front.shape[2]):
                largest = max(largest, front[i, j, k], side[i, j, k], rear[i, j, k])
    return largest


@njit(cache=True)
def _person_states(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    mean: Floats,
    velocity: Floats,
    probability: Floats,
    sizes: Floats,
    margin: Floats,
    spaces: tuple[Floats, Floats, Floats, Floats],
    kind: int,
    scale: float,
    step: float,
) -> tuple[Floats, Floats, Floats, Integers, Floats]:
    """(states, weight, radius, person, fastest) of ``PeopleTable``.

    margin: (P, L+1).  spaces: (axis, front, side, rear) of ``SocialSpaces``.
    """
    axis, front, side, rear = spaces
    n, h, known = mean.shape[0], mean.shape[1], mean.shape[2]
    states = np.empty((n * h, margin.shape[1], 8))
    weight, radius, fastest = np.empty(n * h), np.empty(n * h), np.zeros(n * h)
    person = np.empty(n * h, np.int64)
    for q in range(n * h):
        i, j = q // h, q % h
        weight[q], radius[q], person[q] = probability[i, j], sizes[i], i
        for k in range(known):
            speed = math.hypot(velocity[i, j, k, 0], velocity[i, j, k, 1])
            fastest[q] = max(fastest[q], speed)
        for k in range(margin.shape[1]):
            row = states[q, k]
            m = min(k, known - 1)
            beyond = (k - m) * step
            row[X] = mean[i, j, m, 0] + beyond * velocity[i, j, m, 0]
            row[Y] = mean[i, j, m, 1] + beyond * velocity[i, j, m, 1]
            row[AXIS_X], row[AXIS_Y] = math.cos(axis[i, j, m]), math.sin(axis[i, j, m])
            ahead, aside = front[i, j, m], side[i, j, m]
            behind = ahead if kind == ELLIPSE else rear[i, j, m]
            row[AHEAD] = 0.5 / (scale * ahead * ahead)
            row[BEHIND] = 0.5 / (scale * behind * behind)
            row[ASIDE] = 0.5 / (scale * aside * aside)
            row[MARGIN] = margin[q, k]
    return states, weight, radius, person, fastest


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


@njit(cache=True)
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
    if robot.motion_model.translating == 1:
        fall = fall * np.array([_PLANNED_BRAKING, 1.0])
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
        jerk=robot.max_jerk if robot.motion_model.translating == 1 else math.inf,
        tick=tick,
        n_linear=robot.motion_model.translating,
        top_speed=problem.top_speed,
        facets=np.array(robot.motion_model.facets, dtype=float),
        capsule=robot.capsule.copy(),
        discs=discs.copy(),
        outer_radius=max(math.hypot(x, y) + radius for x, y, radius in discs.tolist()),
    )
