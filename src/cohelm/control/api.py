"""What a local planner is, and what the terms and constraints of its problem are."""

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
from cohelm.robots import Robot


@value
class LocalProblem:
    """Everything a local planner may use."""

    time: float
    """Now, s."""
    robot: Robot
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    twist: Annotated[Floats, Shape("3")]
    """Robot frame."""
    reference: Reference
    """What to follow: the path and the rider's hand, blended."""
    people: People
    predictions: Predictions
    """Over the reference's steps."""
    spaces: SocialSpaces
    walls: DistanceField
    """Distance to all that is not a person: map and live obstacles, about the robot."""
    authority: Authority | None = None
    profile: RiderProfile = RiderProfile()
    speed_limit: float
    """m/s, of robot, rider and request together."""
    stalled: bool = False
    """The ride has not got on for a while: the robot may squeeze past slowly."""
    reverses: bool = False
    """The robot may drive backwards: it is wanted, and what is behind has been seen to be free."""
    late: float = 0.0
    """By how much this tick missed its deadline, s: an input, so that a replay plans the same."""

    def input_bounds(self) -> tuple[Floats, Floats, Floats, Floats]:
        """(lowest, highest input, greatest rise, greatest fall a second), (m,) each.

        The robot's limits under the speed limit; that bounds the norm of the first inputs, see
        ``Kinematics.translating`` and :attr:`top_speed`. Who cannot move sideways does not reverse
        unless it is wanted: it can become the cheapest answer to a barrier.
        """
        over = self.robot.motion.translating
        low, high, rise, fall = self.robot.input_bounds
        forward = over == 1 and not self.reverses
        low, high = _bounded(low, high, over, self.top_speed, forward)
        return low, high, rise, fall

    @property
    def top_speed(self) -> float:
        """The speed over the floor that robot and request allow, m/s."""
        return max(0.0, min(self.robot.max_speed, self.speed_limit))

    def within(self, steps: int) -> LocalProblem:
        """The same problem over the next ``steps`` only, or itself where it is no longer."""
        if steps >= len(self.reference.speeds) - 1:
            return self
        r, p, s = self.reference, self.predictions, self.spaces
        near, groups = np.s_[: steps + 1], s.groups
        whole = np.ascontiguousarray  # as without steps beyond, or kernels are compiled twice

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
    """(lowest, highest input), (m,), of those that translate no more than ``top`` m/s."""
    low, high = low.copy(), high.copy()
    for i in range(translating):
        high[i] = min(high[i], top)
        low[i] = 0.0 if forward else max(low[i], -top)
    return low, high


class LocalPlanner(Protocol):
    """An entry point of ``cohelm.local_planners``; a class with ``Parameters``."""

    steps: int
    """The steps of the reference and the predictions it wants; a plan may have fewer."""
    step: float
    """Time between them, s."""

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """A command and the plan behind it; ``previous`` is the memory. Never moves its arguments.

        Raises:
            ControlError: SolverFailed or Infeasible, with the problem.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """A candidate of the optimal-control problem: inputs and the states they lead to.

    This and the next records live in the solver's inner loop, so they do not check themselves.
    """

    step: float
    """s."""
    poses: Annotated[Floats, Shape("N+1 3")]
    inputs: Annotated[Floats, Shape("N m")]
    last_input: Annotated[Floats, Shape("m")]
    """What the wheels do now."""


class CostTerm(Protocol):
    """One summand ½‖r‖² of the cost, weights included."""

    name: str

    def residual(self, problem: LocalProblem, motion: Motion) -> Floats:
        """r, (q,); asked for at every motion that is tried."""
        ...

    def model(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats
    ) -> tuple[Floats, Floats]:
        """Gauss-Newton's (H, (N·m, N·m); g, (N·m,)) of ½‖r‖²: H = JᵀJ, g = Jᵀr, J = dr/du.

        J follows by the chain rule with ``sensitivity`` = ∂poses/∂inputs; who has no shorter way
        hands r and J to ``costs.gauss_newton``. H may be shared between calls: it is only read.
        """
        ...


_NO_SERIES = np.empty((0, 1)), np.empty((0, 1, 3))


class Measure(NamedTuple):
    """What a constraint finds at a motion: looked at once, for the merit and for the rows.

    This and the next are tuples, which are made in a fifth of the time.
    """

    slack: Annotated[Floats, Shape("g")]
    """What each group needs there, ≥ 0: the merit function prices it."""
    smallest: float = np.inf
    """The smallest h along the motion, m; +inf for what is not a barrier."""
    h: Annotated[Floats, Shape("s N+1")] = _NO_SERIES[0]
    """Barrier values of each series, for the rows; where there are any."""
    gradient: Annotated[Floats, Shape("s N+1 3")] = _NO_SERIES[1]
    """∂h/∂pose."""


class Rows(NamedTuple):
    """Linearised constraints −margin ≤ G·Δu + s ≤ room, with a slack s ≥ 0 for each group.

    Only rows that can become active within one linearisation need to be there.
    """

    margin: Annotated[Floats, Shape("r")]
    """g, how far each row is from its bound; negative where violated."""
    jacobian: Annotated[Floats, Shape("r c")]
    """G, (r, N·m)."""
    group: Annotated[Integers, Shape("r")]
    """Index of each row's slack within this constraint; −1 throughout where there are none."""
    key: Annotated[Integers, Shape("r")]
    """Names each row among all that there can be, whichever of them are present."""
    keys: int
    """How many rows there can be."""
    room: Annotated[Floats, Shape("r")] | None = None
    """How far each row is from an upper bound; None: there is none."""
    groups: int = 0
    """How many slacks there are; 0: the rows are hard."""
    low: Annotated[Floats, Shape("c")] | None = None
    """Least Δu, (N·m,); None: no bound on the inputs themselves."""
    high: Annotated[Floats, Shape("c")] | None = None
    """Greatest Δu."""


class Constraint(Protocol):
    """A stack of constraints; soft rows yield for l1·s + ½·l2·s² a group."""

    name: str
    l1: float
    l2: float

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """What the merit prices; asked for at every motion that is tried."""
        ...

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """The rows that can become active, linearised at ``motion``.

        Args:
            problem: what is to be solved.
            motion: where.
            sensitivity: ∂poses/∂inputs there, (N+1, 3, N·m).
            measure: what :meth:`measure` found at the same motion, not to be computed again.
        """
        ...
