"""Path follower that ignores people: a measure of the avoidance by the people themselves."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import replace
from cohelm.control.api import LocalProblem
from cohelm.control.ss_mpc_dcbf import SsMpcDcbf
from cohelm.messages import LocalPlan, People


class PathFollower:
    """``ss_mpc_dcbf`` with the same tracking problem and walls, but without people.

    It is no path follower in the sense of Nav2 (pure pursuit): it optimises, and avoids walls.
    As a row of a table it shows the contribution of the people to a result. Run its rides with the
    separation of the gate off, because the gate sees people.
    """

    class Parameters(SsMpcDcbf.Parameters):
        """Those of ``ss_mpc_dcbf``; parameters of people have no effect."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._planner = SsMpcDcbf(self.parameters)
        self.steps, self.step = self._planner.steps, self._planner.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        return self._planner.plan(without_people(problem), previous)


def without_people(problem: LocalProblem) -> LocalProblem:
    """The problem without people and groups."""
    p, s = problem.predictions, problem.spaces
    none = np.s_[:0]
    return replace(
        problem,
        people=People.empty(problem.people.time, problem.people.source),
        predictions=replace(
            p,
            weight=p.weight[none],
            mean=p.mean[none],
            velocity=p.velocity[none],
            deviation=p.deviation[none],
        ),
        spaces=replace(
            s,
            axis=s.axis[none],
            front=s.front[none],
            side=s.side[none],
            rear=s.rear[none],
            groups=None,
        ),
    )
