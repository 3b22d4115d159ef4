"""SS-MPC-DCBF: nonlinear MPC with dynamic barriers on social spaces; Xu et al., eq. (11)."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.constraints import Bodies, InputLimits, SocialSpace, WallClearance
from cohelm.control.costs import InputEffort, SmoothInput, TrackReference
from cohelm.control.seeds import best_arcs, followed, last_input, shifted
from cohelm.control.sqp import OptimalControl, Solution, Value
from cohelm.messages import LocalPlan, Reason, Status
from cohelm.robots.contact import braking, first_contact

_FINE = 0.05
"""Between the poses of a braking that is verified, s."""
_RELAXED = 0.01
"""Slack above this is reported as a relaxed plan, m."""


class SocialMpc:
    """The paper's local planner: the reference tracked, people and walls as barriers.

    Every plan is verified before it is used (see :meth:`_verified`): the polished one, else the
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
        wall_margin: float = Field(0.03, ge=0.0)
        """Gap to a wall that verification takes for contact, m."""
        people_margin: float = Field(0.25, ge=0.0)
        """Gap to a person that verification takes for contact, m; see ``first_contact``."""
        squeezing_margin: float = Field(0.05, ge=0.0)
        """The same when the ride is stalled, m."""
        agility: float = Field(0.5, ge=0.0)
        """How fast people may change their velocity, m/s²: hard braking must keep clear of all that
        they can reach, so the chair goes slowly where they are near."""
        verified_time: float = Field(2.0, gt=0.0)
        """How far ahead a plan must be free of contact, s; braking is checked in any case."""
        reaction: float = Field(0.15, gt=0.0)
        """How long a command acts before braking can begin, s: a tick and the drive's lag."""
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallClearance.Parameters = WallClearance.Parameters()
        bodies: Bodies.Parameters = Bodies.Parameters()
        social_space: SocialSpace.Parameters = SocialSpace.Parameters()

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.control = OptimalControl(
            costs=(
                TrackReference(p.track_reference),
                InputEffort(p.input_effort),
                SmoothInput(p.smooth_input),
            ),
            constraints=(
                InputLimits(p.input_limits),
                WallClearance(p.wall_clearance),
                Bodies(p.bodies),
                SocialSpace(p.social_space),
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
        if self._verified(problem, solution.motion):
            status = Status.RELAXED if solution.value.slack > _RELAXED else Status.OK
            return self._plan(problem, solution, solution.motion, status)
        trusted = previous is not None and previous.status is not Status.STOP
        if warm is not None and trusted and self._verified(problem, warm):
            return self._plan(problem, solution, warm, Status.RELAXED)
        for arc in best_arcs(problem, now, self.parameters.rescues):
            if self._verified(problem, arc):
                return self._plan(problem, solution, arc, Status.RELAXED)
        return self._plan(problem, solution, self._brake(problem, now), Status.STOP)

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

    def _verified(self, problem: LocalProblem, motion: Motion) -> bool:
        """Slack is not safety: the plan is clear for a while, and so is braking after its command.

        All swept, against walls and the people's predicted bodies: ordinary braking answers what is
        predicted, hard braking what is not, people who turn as fast as their ``agility`` allows.
        """
        p, robot = self.parameters, problem.robot
        if self._contact(problem, motion.poses, motion.step) < p.verified_time:
            return False
        return all(
            self._contact(
                problem,
                braking(
                    robot,
                    problem.pose,
                    motion.last_input,
                    motion.inputs[0],
                    hold=p.reaction,
                    deceleration=deceleration,
                    step=_FINE,
                ),
                _FINE,
                agility=agility,
            )
            == np.inf
            for deceleration, agility in (
                (robot.max_deceleration, 0.0),
                (robot.emergency_deceleration, p.agility),
            )
        )

    def _contact(
        self, problem: LocalProblem, poses: Floats, step: float, *, agility: float = 0.0
    ) -> float:
        p = self.parameters
        return first_contact(
            problem.robot,
            poses,
            step,
            people=problem.people,
            predictions=problem.predictions,
            walls=problem.walls,
            margin=p.wall_margin,
            people_margin=p.squeezing_margin if problem.stalled else p.people_margin,
            agility=agility,
        )

    def _brake(self, problem: LocalProblem, now: Floats) -> Motion:
        """Speed falls as fast as it may in ordinary driving, the curvature is kept."""
        _, _, _, fall = problem.robot.motion.bounds(problem.robot.limits)
        speed = abs(float(now[0]))
        times = (np.arange(self.steps) + 0.5) * self.step
        left = np.clip(1.0 - fall[0] * times / max(speed, fall[0] * self.step), 0.0, 1.0)
        return followed(problem, left[:, None] * now, now)

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
