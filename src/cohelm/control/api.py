"""Interface of local planners: a :class:`LocalProblem` goes in, a ``LocalPlan`` comes out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, unchecked, value
from cohelm.kernels import CACHED
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
    """X_MR: (x, y, θ) of the robot in the map frame, m, m, rad."""
    twist: Annotated[Floats, Shape("3")]
    """Measured (v_x, v_y, ω) in the robot frame, m/s, m/s, rad/s."""
    reference: Reference
    """Poses and speeds to track, N+1 each: path and rider input, blended."""
    people: People
    predictions: Predictions
    """Of the same people, over the reference's steps or more."""
    spaces: SocialSpaces
    """Personal and group spaces at the predicted positions."""
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
    extra_clearance: float = 0.0
    """Added to the clearance from people, m: the minimum distance of a therapist."""
    max_deviation: float = np.inf
    """Largest angle between the headings of a trajectory and of the reference in the first seconds,
    rad, or the angle now if it is larger."""
    rider_inputs: Floats | None = None
    """(L, m) inputs of the motion that the rider asks for; the plan reports how far it deviates."""
    commanded: Annotated[Floats, Shape("3")] | None = None
    """Twist that the wheels were sent last, after the gate; None: that of the previous plan."""
    last_contact: float = -np.inf
    """Time when a walking person last touched the robot, s; later than now: they are expected to
    touch it until then."""
    late: float = 0.0
    """Delay of this tick, s: an input, so that a replay gives the same plan."""

    def input_bounds(self) -> InputBounds:
        """The robot's limits under the speed limit.

        The speed limit bounds the norm of the first inputs, see ``Kinematics.translating`` and
        :attr:`top_speed`. A robot that cannot move sideways reverses only on request, because
        reversing can become the cheapest answer to a barrier.
        """
        n_linear = self.robot.motion_model.translating
        low, high, rise, fall = self.robot.input_bounds
        forward = n_linear == 1 and not self.reverses
        low, high = _bounded(low, high, n_linear, self.top_speed, forward)
        return InputBounds(low, high, rise, fall)

    @property
    def top_speed(self) -> float:
        """Speed over the floor that robot and request allow, m/s."""
        return max(0.0, min(self.robot.max_speed, self.speed_limit))

    def truncated(self, steps: int) -> LocalProblem:
        """The problem over the next ``steps`` only, or itself where it is no longer."""
        if steps >= len(self.reference.speeds) - 1:
            return self
        r, p, s = self.reference, self.predictions, self.spaces
        first, groups = np.s_[: steps + 1], s.groups
        # contiguous like the uncut arrays, or every kernel is compiled twice
        contiguous = np.ascontiguousarray

        def cut(states: Floats) -> Floats:
            return contiguous(states[:, :, first])

        return unchecked(
            self,
            reference=unchecked(r, poses=r.poses[first], speeds=r.speeds[first]),
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
                groups=groups and unchecked(groups, support=contiguous(groups.support[:, first])),
            ),
        )


@njit(**CACHED)
def _bounded(
    low: Floats, high: Floats, n_linear: int, top: float, forward: bool
) -> tuple[Floats, Floats]:
    """(lowest, highest input), (m,), with the linear velocities within ±``top`` m/s."""
    low, high = low.copy(), high.copy()
    for i in range(n_linear):
        high[i] = min(high[i], top)
        low[i] = 0.0 if forward else max(low[i], -top)
    return low, high


class LocalPlanner(Protocol):
    """Entry point of ``cohelm.local_planners``; a class with ``Parameters``.

    The gate keeps the clearance from people of an attribute ``clearance``, where there is one.
    """

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
class Trajectory:
    """State and input trajectory over the horizon: x_0 … x_N and u_0 … u_{N−1}.

    A record of the inner loop, so it has no checks.
    """

    step: float
    """Δt between two states, s."""
    poses: Annotated[Floats, Shape("N+1 3")]
    """(x, y, θ) of the robot in the map frame, m, m, rad; θ is continuous, not wrapped."""
    inputs: Annotated[Floats, Shape("N m")]
    """(v, ω), or (v_x, v_y, ω) of a holonomic robot, in the robot frame, m/s and rad/s; u_k acts
    from x_k to x_{k+1}."""
    current_input: Annotated[Floats, Shape("m")]
    """u_{−1}: input of the wheels at x_0, from which the first change is measured."""
