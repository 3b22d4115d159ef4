"""A path follower that is blind to people: what the people's own avoiding is worth."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.control.api import LocalProblem
from cohelm.control.ss_mpc_dcbf import SsMpcDcbf
from cohelm.messages import LocalPlan, People


class PathFollower:
    """The same tracking problem and the same walls, with nobody there.

    It is the row beside every table that shows how much of a result is the people's doing. Its
    rides are meant to be run with the gate's separation off, else the gate sees people for it.
    """

    class Parameters(SsMpcDcbf.Parameters):
        """Those of ``ss_mpc_dcbf``; what concerns people has no effect."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._planner = SsMpcDcbf(self.parameters)
        self.steps, self.step = self._planner.steps, self._planner.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        return self._planner.plan(without_people(problem), previous)


def without_people(problem: LocalProblem) -> LocalProblem:
    """The same problem with nobody there, and no group."""
    p, s = problem.predictions, problem.spaces
    none = np.s_[:0]
    return dataclasses.replace(
        problem,
        people=People.nobody(problem.people.time, problem.people.source),
        predictions=dataclasses.replace(
            p,
            weight=p.weight[none],
            mean=p.mean[none],
            velocity=p.velocity[none],
            deviation=p.deviation[none],
        ),
        spaces=dataclasses.replace(
            s,
            axis=s.axis[none],
            front=s.front[none],
            side=s.side[none],
            rear=s.rear[none],
            groups=None,
        ),
    )
