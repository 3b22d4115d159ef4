"""Barrier on people's bodies, with a margin that grows with prediction time."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
from cohelm.control.terms.constraints import barrier
from cohelm.control.terms.constraints.prediction_selection import (
    PersonMargin,
    SelectedPredictions,
    oncoming_share,
    selected_predictions,
)
from cohelm.robots.capsule import nearest_on_spine


class PersonBarrier:
    """h = ‖c − p_i‖ − r_robot − r_i − margin(t) at predicted positions p_i, with person radius r_i.

    c is the point nearest to the person on the spine of the robot's capsule, r_robot the capsule's
    radius; the distance is smooth, and exact for the capsule.
    """

    class Parameters(Model):
        """Barrier and margins; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9); 1 is a plain distance constraint."""
        margin: float = Field(0.10, ge=0.0)
        """Margin to a person now, m."""
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
        """Probability from which a hypothesis counts; a person's most likely one always does."""
        l1: float = Field(60.0, ge=0.0)
        """Weight of the slack, 1/m per person."""
        l2: float = Field(60.0, ge=0.0)
        """Weight of the squared slack, 1/m² per person."""

    name = "bodies"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = PersonMargin(
            initial=p.margin, growth=p.growth, deviations=p.deviations, upper=p.max_margin
        )
        self._stalled = PersonMargin(initial=p.stalled_margin)

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Largest violation by person, over hypotheses and steps, (n,)."""
        people = self._people(problem)
        slack, smallest, h = _values(
            problem.robot.capsule, trajectory.poses, people, self.parameters.gamma
        )
        return ConstraintValues(slack=slack, smallest=smallest, h=h)

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """The rows that can become active."""
        people, h = self._people(problem), values.h
        gamma, capsule = self.parameters.gamma, problem.robot.capsule
        rows = _rows(capsule, trajectory.poses, people, h, sensitivity, gamma)
        return barrier.constraint_rows(rows, people.layout, h.shape[1])

    def _people(self, problem: LocalProblem) -> SelectedPredictions:
        p = self.parameters
        margin = self._stalled if problem.stalled else self._margin
        if p.oncoming_margin > 0.0 and not problem.stalled:
            share = oncoming_share(problem.people, problem.pose)
            margin = _with_growth(margin, p.growth + p.oncoming_margin * share)
        return selected_predictions(problem, p.min_probability, margin, p.gamma, 0.0)


@functools.lru_cache(maxsize=16)
def _with_growth(margin: PersonMargin, growth: float) -> PersonMargin:
    """The margin with another growth; always the same object, because it is a cache key."""
    return replace(margin, growth=growth)


@njit(cache=True)
def _values(
    capsule: Floats, poses: Floats, people: SelectedPredictions, gamma: float
) -> tuple[Floats, float, Floats]:
    """(slack, smallest, h) of ``ConstraintValues``."""
    h = person_barrier(capsule, poses, people.positions, people.clearance)
    slack, smallest = barrier.largest_violations(h, gamma, people.layout)
    return slack, min(smallest, people.lower_bound_of_others), h


@njit(cache=True)
def _rows(
    capsule: Floats,
    poses: Floats,
    people: SelectedPredictions,
    h: Floats,
    sensitivity: Floats,
    gamma: float,
) -> barrier.LinearisedRows:
    """Linearised rows; gradients only where a row may become active."""
    near = barrier.near_states(h, gamma, barrier.NEAR)
    gradient = person_gradient(capsule, poses, people.positions, near)
    return barrier.linearise_dcbf(h, gradient, sensitivity, gamma, barrier.NEAR, people.layout)


@njit(cache=True)
def person_barrier(capsule: Floats, poses: Floats, positions: Floats, clearance: Floats) -> Floats:
    """Barrier values h (q, N+1) of q predicted people.

    poses: (N+1, 3).  positions: (q, N+1, 2).  clearance: (q, N+1), person's radius plus margin.
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
def person_gradient(capsule: Floats, poses: Floats, positions: Floats, near: Booleans) -> Floats:
    """∂h/∂pose (q, N+1, 3) of ``person_barrier``, 0 except at ``near`` (q, N+1)."""
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
