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
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
from cohelm.control.terms.constraints import barrier
from cohelm.control.terms.constraints.prediction_selection import (
    PersonMargin,
    ProblemKey,
    SelectedPredictions,
    selected_predictions,
)
from cohelm.control.terms.constraints.social_distance import (
    SpaceShapes,
    coefficients,
    max_extent,
    social_barrier,
    social_gradient,
)
from cohelm.shapes import ELLIPSE


class SocialSpaceBarrier:
    """h = ‖c − p_i‖ − r_robot − r_i − l_i − l at predicted positions; see ``social_distance``.

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
        """Probability from which a hypothesis counts; a person's most likely one always does."""
        l1: float = Field(4.0, ge=0.0)
        """Weight of the slack, 1/m per person."""
        l2: float = Field(4.0, ge=0.0)
        """Weight of the squared slack, 1/m² per person."""

    name = "social_space"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = PersonMargin(growth=p.growth, deviations=p.deviations, upper=p.max_growth)

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Largest violation by person, over hypotheses and steps, (n,)."""
        spaces = self._spaces(problem)
        slack, smallest, h = _values(trajectory.poses, spaces, self.parameters.gamma)
        return ConstraintValues(slack=slack, smallest=smallest, h=h)

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """The rows that can become active."""
        spaces, h = self._spaces(problem), values.h
        rows = _rows(trajectory.poses, spaces, h, sensitivity, self.parameters.gamma)
        return barrier.constraint_rows(rows, spaces.people.layout, h.shape[1])

    def _spaces(self, problem: LocalProblem) -> _SelectedSpaces:
        p = self.parameters
        bodies = p.distance == "bodies"
        return _spaces(problem, p.min_probability, self._margin, p.gamma, bodies)


class _SelectedSpaces(NamedTuple):
    """The spaces of the selected hypotheses."""

    capsule: Floats
    """``Robot.capsule``, or a point as printed."""
    people: SelectedPredictions
    """With the person's radius in the clearance, or without it as printed."""
    shapes: SpaceShapes


@functools.lru_cache(maxsize=16)
def _spaces(
    problem: LocalProblem, min_probability: float, margin: PersonMargin, gamma: float, bodies: bool
) -> _SelectedSpaces:
    """The spaces of a problem, computed once for all trial trajectories."""
    return _spaces_of(ProblemKey(problem), min_probability, margin, gamma, bodies)


@functools.lru_cache(maxsize=16)
def _spaces_of(
    key: ProblemKey, min_probability: float, margin: PersonMargin, gamma: float, bodies: bool
) -> _SelectedSpaces:
    problem = key.problem
    s = problem.spaces
    extent = max_extent(s.kind, s.scale, s.front, s.side, s.rear, s.floor)
    robot, robot_extent = _robot_space(s.kind, s.scale, tuple(s.robot.tolist()), s.robot_floor)
    people = selected_predictions(problem, min_probability, margin, gamma, extent + robot_extent)
    axis, shape = _shapes_of(
        s.kind, s.scale, s.axis, s.front, s.side, s.rear, people.layout.series_id
    )
    if not bodies:
        radius = problem.people.radius[people.layout.slack_index][:, None]
        people = people._replace(clearance=people.clearance - radius)
    return _SelectedSpaces(
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
def _shapes_of(  # noqa: PLR0917  # a kernel takes plain arrays
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
def _values(poses: Floats, spaces: _SelectedSpaces, gamma: float) -> tuple[Floats, float, Floats]:
    """(slack, smallest, h) of ``ConstraintValues``."""
    people = spaces.people
    h = social_barrier(spaces.capsule, poses, people.positions, people.clearance, spaces.shapes)
    slack, smallest = barrier.largest_violations(h, gamma, people.layout)
    return slack, min(smallest, people.lower_bound_of_others), h


@njit(cache=True)
def _rows(
    poses: Floats, spaces: _SelectedSpaces, h: Floats, sensitivity: Floats, gamma: float
) -> barrier.LinearisedRows:
    """Linearised rows; gradients only where a row may become active."""
    near, people = barrier.near_states(h, gamma, barrier.NEAR), spaces.people
    gradient = social_gradient(spaces.capsule, poses, people.positions, spaces.shapes, near)
    return barrier.linearise_dcbf(h, gradient, sensitivity, gamma, barrier.NEAR, people.layout)
