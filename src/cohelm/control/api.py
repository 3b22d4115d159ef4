"""Interfaces of local planners, and of the terms and constraints of their problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape, unchecked, value
from cohelm.maps import DistanceField
from cohelm.messages import (
    Authority,
    LocalPlan,
    People,
    Predictions,
    Reference,
    RiderProfile,
    SocialSpaces,
)
from cohelm.robots import InputBounds, Robot


@value
class LocalProblem:
    """Input of a local planner."""

    time: float
    """Now, s."""
    robot: Robot
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    twist: Annotated[Floats, Shape("3")]
    """Robot frame."""
    reference: Reference
    """The shared reference: path and rider input, blended."""
    people: People
    predictions: Predictions
    """Over the reference's steps."""
    spaces: SocialSpaces
    walls: DistanceField
    """Distance to everything that is not a person: map and live obstacles around the robot."""
    authority: Authority | None = None
    profile: RiderProfile = RiderProfile()
    speed_limit: float
    """Smallest of the limits of robot, rider and request, m/s."""
    stalled: bool = False
    """The ride makes no progress: the robot may squeeze past people slowly."""
    reverses: bool = False
    """Reversing is requested, and the rear clearance is known."""
    late: float = 0.0
    """Delay of this tick, s: an input, so that a replay gives the same plan."""

    def input_bounds(self) -> InputBounds:
        """The robot's limits under the speed limit.

        The speed limit bounds the norm of the first inputs, see ``Kinematics.translating`` and
        :attr:`top_speed`. A robot that cannot move sideways reverses only on request, because
        reversing can become the cheapest answer to a barrier.
        """
        over = self.robot.motion.translating
        low, high, rise, fall = self.robot.input_bounds
        forward = over == 1 and not self.reverses
        low, high = _bounded(low, high, over, self.top_speed, forward)
        return InputBounds(low, high, rise, fall)

    @property
    def top_speed(self) -> float:
        """Speed over the floor that robot and request allow, m/s."""
        return max(0.0, min(self.robot.max_speed, self.speed_limit))

    def within(self, steps: int) -> LocalProblem:
        """The problem over the next ``steps`` only, or itself where it is no longer."""
        if steps >= len(self.reference.speeds) - 1:
            return self
        r, p, s = self.reference, self.predictions, self.spaces
        near, groups = np.s_[: steps + 1], s.groups
        # contiguous like the uncut arrays, or every kernel is compiled twice
        whole = np.ascontiguousarray

        def cut(states: Floats) -> Floats:
            return whole(states[:, :, near])

        return unchecked(
            self,
            reference=unchecked(r, poses=r.poses[near], speeds=r.speeds[near]),
            predictions=unchecked(
                p,
                mean=cut(p.mean),
                velocity=cut(p.velocity),
                deviation=cut(p.deviation),
            ),
            spaces=unchecked(
                s,
                axis=cut(s.axis),
                front=cut(s.front),
                side=cut(s.side),
                rear=cut(s.rear),
                groups=groups and unchecked(groups, support=whole(groups.support[:, near])),
            ),
        )


@njit(cache=True)
def _bounded(
    low: Floats, high: Floats, translating: int, top: float, forward: bool
) -> tuple[Floats, Floats]:
    """(lowest, highest input), (m,), with translating inputs within ±``top`` m/s."""
    low, high = low.copy(), high.copy()
    for i in range(translating):
        high[i] = min(high[i], top)
        low[i] = 0.0 if forward else max(low[i], -top)
    return low, high


class LocalPlanner(Protocol):
    """Entry point of ``cohelm.local_planners``; a class with ``Parameters``."""

    steps: int
    """Steps of reference and predictions that it needs; a plan may have fewer."""
    step: float
    """Time between them, s."""

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """Command and plan; ``previous`` is the memory. Arguments are not changed.

        Raises:
            ControlError: SolverFailed or Infeasible, with the problem.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A point of the optimal-control problem: inputs and the resulting states.

    The solver's inner loop creates this record and the next ones, so they have no checks.
    """

    step: float
    """s."""
    poses: Annotated[Floats, Shape("N+1 3")]
    inputs: Annotated[Floats, Shape("N m")]
    last_input: Annotated[Floats, Shape("m")]
    """Current input."""


class CostTerm(Protocol):
    """One summand ½‖r‖² of the cost, including its weights."""

    name: str

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """r, (q,); evaluated at every trial motion."""
        ...

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """Gauss-Newton's (H, (N·m, N·m); g, (N·m,)) of ½‖r‖²: H = JᵀJ, g = Jᵀr, J = dr/du.

        J follows by the chain rule from ``sensitivity`` = ∂poses/∂inputs; ``terms.gauss_newton``
        serves terms without a closed form. H may be shared between calls: it is only read.
        """
        ...


_NO_SERIES = np.empty((0, 1)), np.empty((0, 1, 3))


class ConstraintValues(NamedTuple):
    """Values of a constraint at a motion, for the merit function and for the rows.

    A tuple, because it is created five times faster than a dataclass.
    """

    slack: Annotated[Floats, Shape("g")]
    """Violation of each group, ≥ 0, which the merit function penalises."""
    smallest: float = np.inf
    """Smallest h along the motion, m; +inf without a barrier."""
    h: Annotated[Floats, Shape("s N+1")] = _NO_SERIES[0]
    """Barrier values of each series, if any."""
    gradient: Annotated[Floats, Shape("s N+1 3")] = _NO_SERIES[1]
    """∂h/∂pose."""


class ConstraintRows(NamedTuple):
    """Linearised constraints −margin ≤ G·Δu + s ≤ upper, with a slack s ≥ 0 for each group.

    Rows that cannot become active within one linearisation may be left out.
    """

    margin: Annotated[Floats, Shape("r")]
    """g, distance of each row from its lower bound; negative where violated."""
    jacobian: Annotated[Floats, Shape("r c")]
    """G, (r, N·m)."""
    group: Annotated[Integers, Shape("r")]
    """Index of each row's slack within this constraint; −1 for all rows without slack."""
    key: Annotated[Integers, Shape("r")]
    """Identifier of each row among all possible rows of the constraint."""
    keys: int
    """Number of possible rows."""
    upper: Annotated[Floats, Shape("r")] | None = None
    """Distance of each row from an upper bound; None: there is none."""
    groups: int = 0
    """Number of slacks; 0: the rows are hard."""
    low: Annotated[Floats, Shape("c")] | None = None
    """Lower bound of Δu; None: the inputs themselves are not bounded."""
    high: Annotated[Floats, Shape("c")] | None = None
    """Upper bound of Δu."""


class Constraint(Protocol):
    """A stack of constraints; soft rows have the penalty l1·s + ½·l2·s² per group."""

    name: str
    l1: float
    l2: float

    def values(self, problem: LocalProblem, motion: Motion) -> ConstraintValues:
        """Values for the merit function; evaluated at every trial motion."""
        ...

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, values: ConstraintValues
    ) -> ConstraintRows:
        """The rows that can become active, linearised at ``motion``.

        Args:
            problem: the problem to be solved.
            motion: point of linearisation.
            sensitivity: ∂poses/∂inputs there, (N+1, 3, N·m).
            values: result of :meth:`values` at the same motion.
        """
        ...
