"""What sampling alone is worth: the best sampled arc, driven as it is."""

from __future__ import annotations

from pydantic import Field

from cohelm.config import Model
from cohelm.control import LocalProblem
from cohelm.control.candidates import Arcs
from cohelm.control.warm_start import last_input, shifted
from cohelm.messages import LocalPlan, Status


class BestArc:
    """No polish, no verification: a row beside the planners', not one of them."""

    class Parameters(Model):
        """Of the sampling."""

        steps: int = Field(24, ge=3, le=100)
        """N."""
        step: float = Field(0.25, gt=0.0, le=1.0)
        """Δt, s."""
        arcs: Arcs.Parameters = Arcs.Parameters(stride=1)

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.arcs = Arcs(p.arcs)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        now = last_input(problem, previous)
        steps = None if previous is None else len(previous.inputs)
        ways = self.arcs.ways(problem, now, shifted(problem, previous, now, steps))
        return LocalPlan(
            time=problem.time,
            step=ways.step,
            command=problem.robot.motion.twist(ways.inputs[0, 0]),
            poses=ways.poses[0],
            inputs=ways.inputs[0],
            status=Status.OK,
        )
