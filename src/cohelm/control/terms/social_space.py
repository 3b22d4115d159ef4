"""Barrier on personal space: the dynamic control barrier of Xu et al., eqs. (8) and (9)."""

from __future__ import annotations

import functools
import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Motion
from cohelm.control.terms import barrier
from cohelm.control.terms.binding import (
    BindingPredictions,
    PersonMargin,
    ProblemKey,
    binding_predictions,
)
from cohelm.control.terms.social_distance import (
    SpaceShapes,
    coefficients,
    max_extent,
    social_barrier,
    social_gradient,
)
from cohelm.shapes import ELLIPSE


class SocialSpace:
    """h = ‖c − p_i‖ − r_body − r_i − l_i − l at predicted positions; see ``social_distance``.

    The robot's own extent l depends on its speed, which is a decision variable here; it is frozen
    at the measured speed within a solve.
    """

    class Parameters(Model):
        """Barrier and weights, assumed: small, because in a narrow corridor it must yield."""

        gamma: float = Field(0.15, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        distance: Literal["bodies", "printed"] = "bodies"
        """Between footprint and body, or between their centres as printed."""
        growth: float = Field(0.0, ge=0.0)
        """Growth of a space with prediction time, m/s."""
        deviations: float = Field(0.0, ge=0.0, le=5.0)
        """Standard deviations of the predicted position that are added to a space."""
        max_growth: float = Field(0.3, ge=0.0)
        """Upper bound of both, m."""
        min_probability: float = Field(0.3, ge=0.0, le=1.0)
        """Probability from which a hypothesis binds; a person's most likely one always does."""
        l1: float = Field(4.0, ge=0.0)
        """Weight of the slack, 1/m per person."""
        l2: float = Field(4.0, ge=0.0)
        """Weight of the squared slack, 1/m² per person."""

    name = "social_space"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = PersonMargin(growth=p.growth, deviations=p.deviations, upper=p.max_growth)

    def values(self, problem: LocalProblem, motion: Motion) -> ConstraintValues:
        """Largest violation by person, over hypotheses and steps, (n,)."""
        found = self._spaces(problem)
        return ConstraintValues(*_values(motion.poses, found, self.parameters.gamma))

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, values: ConstraintValues
    ) -> ConstraintRows:
        """The rows that can become active."""
        found, h = self._spaces(problem), values.h
        rows = _rows(motion.poses, found, h, sensitivity, self.parameters.gamma)
        return barrier.constraint_rows(rows, found.people.series, h.shape[1])

    def _spaces(self, problem: LocalProblem) -> _BindingSpaces:
        p = self.parameters
        bodies = p.distance == "bodies"
        return _spaces(problem, p.min_probability, self._margin, p.gamma, bodies)


class _BindingSpaces(NamedTuple):
    """The spaces of the hypotheses that bind."""

    capsule: Floats
    """``Robot.capsule``, or a point as printed."""
    people: BindingPredictions
    """With the body's radius in the clearance, or without it as printed."""
    shapes: SpaceShapes


@functools.lru_cache(maxsize=16)
def _spaces(
    problem: LocalProblem, min_probability: float, margin: PersonMargin, gamma: float, bodies: bool
) -> _BindingSpaces:
    """The spaces of a problem, computed once for all trial motions."""
    return _spaces_of(ProblemKey(problem), min_probability, margin, gamma, bodies)


@functools.lru_cache(maxsize=16)
def _spaces_of(
    key: ProblemKey, min_probability: float, margin: PersonMargin, gamma: float, bodies: bool
) -> _BindingSpaces:
    problem = key.problem
    s = problem.spaces
    extent = max_extent(s.kind, s.scale, s.front, s.side, s.rear, s.floor)
    robot, own = _robot_space(s.kind, s.scale, tuple(s.robot.tolist()), s.robot_floor)
    people = binding_predictions(problem, min_probability, margin, gamma, extent + own)
    axis, shape = _selected(s.kind, s.scale, s.axis, s.front, s.side, s.rear, people.series.name)
    if not bodies:
        radius = problem.people.radius[people.series.owner][:, None]
        people = people._replace(clearance=people.clearance - radius)
    return _BindingSpaces(
        problem.robot.capsule if bodies else np.zeros(5),
        people,
        SpaceShapes(s.kind, axis, shape, s.floor, robot, s.robot_floor),
    )


@functools.lru_cache(maxsize=64)
def _robot_space(
    kind: int, scale: float, sigma: tuple[float, ...], floor: float
) -> tuple[Floats, float]:
    """(``coefficients`` of the robot's own space, its largest extent)."""
    front, side, rear = (np.array([part]) for part in sigma)
    shape = coefficients(kind, scale, front, side, rear)[0]
    return shape, max_extent(kind, scale, front, side, rear, floor)


@njit(cache=True)
def _selected(  # noqa: PLR0917  # a kernel takes plain arrays
    kind: int,
    scale: float,
    axis: Floats,
    front: Floats,
    side: Floats,
    rear: Floats,
    which: Integers,
) -> tuple[Floats, Floats]:
    """(axes (q, N+1, 2), ``coefficients`` (q, N+1, 3)) of some of the hypotheses."""
    hypotheses, states = max(axis.shape[1], 1), axis.shape[2]
    unit, shape = np.empty((len(which), states, 2)), np.empty((len(which), states, 3))
    for q in range(len(which)):
        i, j = which[q] // hypotheses, which[q] % hypotheses
        for k in range(states):
            unit[q, k, 0], unit[q, k, 1] = math.cos(axis[i, j, k]), math.sin(axis[i, j, k])
            ahead, aside = front[i, j, k], side[i, j, k]
            behind = ahead if kind == ELLIPSE else rear[i, j, k]
            shape[q, k, 0] = 0.5 / (scale * ahead * ahead)
            shape[q, k, 1] = 0.5 / (scale * behind * behind)
            shape[q, k, 2] = 0.5 / (scale * aside * aside)
    return unit, shape


@njit(cache=True)
def _values(poses: Floats, spaces: _BindingSpaces, gamma: float) -> tuple[Floats, float, Floats]:
    """(slack, smallest, h) of ``ConstraintValues``."""
    people = spaces.people
    h = social_barrier(spaces.capsule, poses, people.positions, people.clearance, spaces.shapes)
    slack, smallest = barrier.worst(h, gamma, people.series)
    return slack, min(smallest, people.elsewhere), h


@njit(cache=True)
def _rows(
    poses: Floats, spaces: _BindingSpaces, h: Floats, sensitivity: Floats, gamma: float
) -> tuple[Floats, Floats, Integers, Integers]:
    """Rows as of ``barrier.linearised``; gradients only where a row may become active."""
    near, people = barrier.near_states(h, gamma, barrier.NEAR), spaces.people
    gradient = social_gradient(spaces.capsule, poses, people.positions, spaces.shapes, near)
    return barrier.linearised(h, gradient, sensitivity, gamma, barrier.NEAR, people.series)
