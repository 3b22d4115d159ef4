"""People as a table: their predicted states, personal spaces and clearance over the horizon."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.api import LocalProblem
from cohelm.kernels import CACHED
from cohelm.robots.clearance import Clearance, oncoming_share, people_margins
from cohelm.shapes import ELLIPSE, PRINTED

DECAY_TIME = 4.0
"""Time constant with which the weight of predictions decays, s: about the time of a passage."""
X, Y, AXIS_X, AXIS_Y, AHEAD, BEHIND, ASIDE, MARGIN = range(8)
"""Columns of ``PeopleTable.states``."""


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
    num_people: int
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


def people_table(problem: LocalProblem, steps: int, clearance: Clearance) -> PeopleTable:
    """The people over L steps with their clearance."""
    p, s = problem.predictions, problem.spaces
    law = clearance.law(
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
        fade=_fade(problem.reference.step, steps),
        num_people=len(problem.people),
        printed=printed,
        floor=s.floor,
        extent=max(extent, s.floor) if len(problem.people) else 0.0,
        largest_margin=law.upper + law.extra,
        own=own,
        own_floor=s.robot_floor,
        own_extent=own_extent,
    )


@functools.lru_cache(maxsize=64)
def _fade(step: float, steps: int) -> Floats:
    """exp(−t / DECAY_TIME), (L+1,)."""
    return np.asarray(np.exp(-step * np.arange(steps + 1) / DECAY_TIME))


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


@njit(**CACHED)
def _widest(front: Floats, side: Floats, rear: Floats) -> float:
    """Largest of all σ."""
    largest = 0.0
    for i in range(front.shape[0]):
        for j in range(front.shape[1]):
            for k in range(front.shape[2]):
                largest = max(largest, front[i, j, k], side[i, j, k], rear[i, j, k])
    return largest


@njit(**CACHED)
def _person_states(
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
