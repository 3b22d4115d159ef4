"""Barrier on people's bodies, with a margin that grows with prediction time."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Motion
from cohelm.control.terms import barrier
from cohelm.control.terms.binding import (
    BindingPredictions,
    PersonMargin,
    binding_predictions,
    oncoming_share,
)
from cohelm.robots.capsule import nearest_on_spine


class BodyClearance:
    """h = ‖c − p_i‖ − r_body − r_i − margin(t) at predicted positions.

    c is the point of the capsule's spine nearest to the person; the distance is smooth, and exact
    for the capsule.
    """

    class Parameters(Model):
        """Barrier and margins; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9); 1 is a plain distance constraint."""
        margin: float = Field(0.10, ge=0.0)
        """Margin to a body now, m."""
        growth: float = Field(0.08, ge=0.0)
        """Growth of the margin with prediction time, m/s."""
        oncoming_margin: float = Field(0.0, ge=0.0)
        """Additional growth for oncoming people, m/s; see ``oncoming_share``."""
        deviations: float = Field(0.0, ge=0.0, le=5.0)
        """Standard deviations of the predicted position that are added to the margin."""
        max_margin: float = Field(0.35, ge=0.0)
        """Upper bound of the margin, m."""
        stalled_margin: float = Field(0.06, ge=0.0)
        """Margin while the ride is stalled, m; it does not grow then."""
        min_probability: float = Field(0.15, ge=0.0, le=1.0)
        """Probability from which a hypothesis binds; a person's most likely one always does."""
        l1: float = Field(60.0, ge=0.0)
        """Weight of the slack, 1/m per person."""
        l2: float = Field(60.0, ge=0.0)
        """Weight of the squared slack, 1/m² per person."""

    name = "bodies"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = PersonMargin(
            now=p.margin, growth=p.growth, deviations=p.deviations, upper=p.max_margin
        )
        self._stalled = PersonMargin(now=p.stalled_margin)

    def values(self, problem: LocalProblem, motion: Motion) -> ConstraintValues:
        """Largest violation by person, over hypotheses and steps, (n,)."""
        people = self._people(problem)
        return ConstraintValues(
            *_values(problem.robot.capsule, motion.poses, people, self.parameters.gamma)
        )

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, values: ConstraintValues
    ) -> ConstraintRows:
        """The rows that can become active."""
        people, h = self._people(problem), values.h
        gamma, capsule = self.parameters.gamma, problem.robot.capsule
        rows = _rows(capsule, motion.poses, people, h, sensitivity, gamma)
        return barrier.constraint_rows(rows, people.series, h.shape[1])

    def _people(self, problem: LocalProblem) -> BindingPredictions:
        p = self.parameters
        margin = self._stalled if problem.stalled else self._margin
        if p.oncoming_margin > 0.0 and not problem.stalled:
            share = oncoming_share(problem.people, problem.pose)
            margin = _with_growth(margin, p.growth + p.oncoming_margin * share)
        return binding_predictions(problem, p.min_probability, margin, p.gamma, 0.0)


@functools.lru_cache(maxsize=16)
def _with_growth(margin: PersonMargin, growth: float) -> PersonMargin:
    """The margin with another growth; always the same object, because it is a cache key."""
    return replace(margin, growth=growth)


@njit(cache=True)
def _values(
    capsule: Floats, poses: Floats, people: BindingPredictions, gamma: float
) -> tuple[Floats, float, Floats]:
    """(slack, smallest, h) of ``ConstraintValues``."""
    h = body_barrier(capsule, poses, people.positions, people.clearance)
    slack, smallest = barrier.worst(h, gamma, people.series)
    return slack, min(smallest, people.elsewhere), h


@njit(cache=True)
def _rows(
    capsule: Floats,
    poses: Floats,
    people: BindingPredictions,
    h: Floats,
    sensitivity: Floats,
    gamma: float,
) -> tuple[Floats, Floats, Integers, Integers]:
    """Rows as of ``barrier.linearised``; gradients only where a row may become active."""
    near = barrier.near_states(h, gamma, barrier.NEAR)
    gradient = body_gradient(capsule, poses, people.positions, near)
    return barrier.linearised(h, gradient, sensitivity, gamma, barrier.NEAR, people.series)


@njit(cache=True)
def body_barrier(capsule: Floats, poses: Floats, positions: Floats, clearance: Floats) -> Floats:
    """Values h (q, N+1) against bodies.

    poses: (N+1, 3).  positions: (q, N+1, 2).  clearance: (q, N+1), the body's radius and the
    margin.
    """
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    h = np.empty((positions.shape[0], poses.shape[0]))
    for i in range(h.shape[0]):
        for k in range(h.shape[1]):
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            d = nearest_on_spine(capsule, cos[k], sin[k], dx, dy)[0]
            h[i, k] = d - capsule[4] - clearance[i, k]
    return h


@njit(cache=True)
def body_gradient(capsule: Floats, poses: Floats, positions: Floats, near: Booleans) -> Floats:
    """∂h/∂pose (q, N+1, 3) of ``body_barrier``, 0 except at ``near`` (q, N+1)."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    out = np.zeros((positions.shape[0], poses.shape[0], 3))
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            if not near[i, k]:
                continue
            dx, dy = positions[i, k, 0] - poses[k, 0], positions[i, k, 1] - poses[k, 1]
            _, ex, ey, sx, sy, _ = nearest_on_spine(capsule, cos[k], sin[k], dx, dy)
            out[i, k, 0] = -(cos[k] * ex - sin[k] * ey)
            out[i, k, 1] = -(sin[k] * ex + cos[k] * ey)
            out[i, k, 2] = ex * sy - ey * sx
    return out
