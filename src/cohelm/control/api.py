"""What a local planner is, and what the terms and constraints of its problem are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
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

        The robot's limits under the speed limit. No reversing unless it is wanted: it can become
        the cheapest answer to a barrier.
        """
        low, high, rise, fall = self.robot.motion.bounds(self.robot.limits)
        low, high = low.copy(), high.copy()
        low[0] = low[0] if self.reverses else 0.0
        high[0] = min(high[0], self.speed_limit)
        return low, high, rise, fall

    def within(self, steps: int) -> LocalProblem:
        """The same problem over the next ``steps`` only, or itself where it is no longer."""
        if steps >= len(self.reference.speeds) - 1:
            return self
        r, p, s = self.reference, self.predictions, self.spaces
        near = np.s_[: steps + 1]
        return replace(
            self,
            reference=replace(r, poses=r.poses[near], speeds=r.speeds[near]),
            predictions=replace(
                p,
                mean=p.mean[:, :, near],
                velocity=p.velocity[:, :, near],
                deviation=p.deviation[:, :, near],
            ),
            spaces=replace(
                s,
                axis=s.axis[:, :, near],
                front=s.front[:, :, near],
                side=s.side[:, :, near],
                rear=s.rear[:, :, near],
                groups=s.groups and replace(s.groups, support=s.groups.support[:, near]),
            ),
        )


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
        """r, (q,)."""
        ...

    def jacobian(self, problem: LocalProblem, motion: Motion, sensitivity: Floats) -> Floats:
        """dr/du, (q, N·m), by the chain rule with ``sensitivity`` = ∂poses/∂inputs."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Linearised constraints −margin ≤ G·Δu + s ≤ room, with a slack s ≥ 0 for each group."""

    margin: Annotated[Floats, Shape("r")]
    """g, how far each row is from its bound; negative where violated."""
    jacobian: Annotated[Floats, Shape("r c")]
    """G, (r, N·m)."""
    group: Annotated[Integers, Shape("r")]
    """Index of each row's slack within this constraint, −1: hard."""
    room: Annotated[Floats, Shape("r")] | None = None
    """How far each row is from an upper bound; None: there is none."""
    key: Annotated[Integers, Shape("r")]
    """Names each row among all that there can be, whichever of them are present."""
    keys: int
    """How many rows there can be."""
    groups: int = 0
    """How many slacks there are."""


class Constraint(Protocol):
    """A stack of constraints; soft rows yield for l1·s + ½·l2·s² a group."""

    name: str
    l1: float
    l2: float

    def measure(self, problem: LocalProblem, motion: Motion) -> tuple[Floats, float]:
        """(slack that each group needs at ``motion``, ≥ 0; the smallest h along it, m).

        The merit function prices the first; the second is +inf for what is not a barrier.
        """
        ...

    def rows(self, problem: LocalProblem, motion: Motion, sensitivity: Floats) -> Rows:
        """The rows that can become active, linearised at ``motion``."""
        ...

    def box(self, problem: LocalProblem, motion: Motion) -> tuple[Floats, Floats] | None:
        """Bounds (low, high), (N·m,) each, on Δu itself; None: there are none."""
        ...
