"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11)."""

from __future__ import annotations

from types import MappingProxyType

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.candidates import best_arcs
from cohelm.control.constraints import (
    Bodies,
    GroupSpace,
    InputLimits,
    SocialSpace,
    WallClearance,
)
from cohelm.control.costs import Comfort, InputEffort, Progress, SmoothInput, TrackReference
from cohelm.control.sqp import OptimalControl, Solution, Value
from cohelm.control.verification import Verification, brought_to_rest
from cohelm.control.warm_start import last_input, shifted
from cohelm.messages import LocalPlan, Reason, Status

_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""


class SsMpcDcbf:
    """The paper's local planner: the reference tracked, people and walls as barriers.

    Every plan is verified before it is used (see ``verification``): the polished one, else the
    last plan shifted, else the cheapest sampled arc that passes, else braking with a stated reason.
    """

    class Parameters(Model):
        """Horizon, budget, terms and constraints; the paper gives no figures, these are assumed."""

        steps: int = Field(25, ge=3, le=100)
        """N."""
        step: float = Field(0.16, gt=0.0, le=1.0)
        """Δt, s; longer than a tick, which is why the last plan is shifted by interpolation."""
        iterations: int = Field(2, ge=1, le=50)
        """Quadratic programs a plan: the budget, the same on every machine."""
        switch: float = Field(0.8, gt=0.0, le=1.0)
        """A sampled way round replaces the last plan where its merit is below this share of it."""
        rescues: int = Field(12, ge=0, le=72)
        """Sampled arcs that are tried, best first, before the chair brakes."""
        verification: Verification = Verification()
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        comfort: Comfort.Parameters = Comfort.Parameters()
        progress: Progress.Parameters = Progress.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallClearance.Parameters = WallClearance.Parameters()
        bodies: Bodies.Parameters = Bodies.Parameters()
        social_space: SocialSpace.Parameters = SocialSpace.Parameters()
        group_space: GroupSpace.Parameters = GroupSpace.Parameters()

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.control = OptimalControl(
            costs=(
                TrackReference(p.track_reference),
                InputEffort(p.input_effort),
                SmoothInput(p.smooth_input),
                Comfort(p.comfort),
                Progress(p.progress),
            ),
            constraints=(
                InputLimits(p.input_limits),
                WallClearance(p.wall_clearance),
                Bodies(p.bodies),
                SocialSpace(p.social_space),
                GroupSpace(p.group_space),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        now = last_input(problem, previous)
        warm = shifted(problem, previous, now)
        seed, value = self._seed(problem, warm, now)
        solution = self.control.solve(
            problem, seed, iterations=self.parameters.iterations, value=value
        )
        if self.parameters.verification.passes(problem, solution.motion):
            status = Status.RELAXED if solution.value.slack > _RELAXED else Status.OK
            return self._plan(problem, solution, solution.motion, status)
        trusted = previous is not None and previous.status is not Status.STOP
        if warm is not None and trusted and self.parameters.verification.passes(problem, warm):
            return self._plan(problem, solution, warm, Status.RELAXED)
        for arc in best_arcs(problem, now, self.parameters.rescues):
            if self.parameters.verification.passes(problem, arc):
                return self._plan(problem, solution, arc, Status.RELAXED)
        return self._plan(problem, solution, brought_to_rest(problem, now, self.steps), Status.STOP)

    def _seed(
        self, problem: LocalProblem, warm: Motion | None, now: Floats
    ) -> tuple[Motion, Value]:
        arc = next(best_arcs(problem, now, 1))
        other = self.control.value(problem, arc)
        if warm is None:
            return arc, other
        ours = self.control.value(problem, warm)
        if other.merit < self.parameters.switch * ours.merit:
            return arc, other
        return warm, ours

    def _plan(
        self, problem: LocalProblem, solution: Solution, motion: Motion, status: Status
    ) -> LocalPlan:
        used = motion is solution.motion
        value = solution.value if used else self.control.value(problem, motion)
        return LocalPlan(
            time=problem.time,
            step=motion.step,
            command=problem.robot.motion.twist(motion.inputs[0]),
            poses=motion.poses,
            inputs=motion.inputs,
            status=status,
            reason=Reason.NO_SAFE_PLAN if status is Status.STOP else None,
            costs=MappingProxyType(dict(value.costs)),
            smallest_barrier=value.barrier,
            slack=value.slack,
            iterations=solution.iterations,
        )
