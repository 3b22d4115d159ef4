"""Do not touch people: a barrier on bodies, with a margin that grows with the prediction's age."""

from __future__ import annotations

import functools
from dataclasses import replace

from numba import njit
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.futures import Futures, Margin, futures
from cohelm.control.constraints.separation import body_barrier, body_gradient
from cohelm.control.room import share_of_room


class Bodies:
    """h = ‖c − p_i‖ − r_body − r_i − margin(t) at predicted positions; see ``separation``."""

    class Parameters(Model):
        """Barrier and margins; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9); 1 is a plain distance constraint."""
        margin: float = Field(0.10, ge=0.0)
        """Distance kept from a body now, m."""
        growth: float = Field(0.08, ge=0.0)
        """How the margin grows with prediction time, m/s."""
        berth: float = Field(0.0, ge=0.0)
        """By how much more it grows where somebody walks against the robot, m/s; see ``room``."""
        deviations: float = Field(0.0, ge=0.0, le=5.0)
        """By how many standard deviations of the predicted position the margin grows besides."""
        greatest: float = Field(0.35, ge=0.0)
        """The margin's bound, m."""
        squeezing: float = Field(0.06, ge=0.0)
        """The margin when the ride is stalled, m; it does not grow then."""
        at_least: float = Field(0.15, ge=0.0, le=1.0)
        """Probability from which on a future binds; a person's likeliest always does."""
        l1: float = Field(60.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(60.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "bodies"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = Margin(
            now=p.margin, growth=p.growth, deviations=p.deviations, most=p.greatest
        )
        self._squeezing = Margin(now=p.squeezing)

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By person, the worst over futures and steps, (n,)."""
        who = self._futures(problem)
        return who.measure(
            *_measured(
                problem.robot.capsule,
                motion.poses,
                who.positions,
                who.kept,
                self.parameters.gamma,
                who.person,
                who.people,
            )
        )

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        who = self._futures(problem)
        return who.rows(
            measure.h,
            *_linearised(
                problem.robot.capsule,
                motion.poses,
                who.positions,
                measure.h,
                sensitivity,
                self.parameters.gamma,
                who.person,
                who.which,
            ),
        )

    def _futures(self, problem: LocalProblem) -> Futures:
        p = self.parameters
        margin = self._squeezing if problem.stalled else self._margin
        if p.berth > 0.0 and not problem.stalled:
            share = share_of_room(problem.people, problem.pose)
            margin = _grown(margin, p.growth + p.berth * share)
        return futures(problem, p.at_least, margin, p.gamma, 0.0)


@functools.lru_cache(maxsize=16)
def _grown(margin: Margin, growth: float) -> Margin:
    """A margin that grows otherwise; the same object each time, as what follows is found by it."""
    return replace(margin, growth=growth)


@njit(cache=True)
def _measured(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    kept: Floats,
    gamma: float,
    person: Integers,
    people: int,
) -> tuple[Floats, Floats, float]:
    """(h, slack, the smallest h); see ``Futures.measure``."""
    h = body_barrier(capsule, poses, positions, kept)
    slack, smallest = barrier.worst_of(h, gamma, person, people)
    return h, slack, smallest


@njit(cache=True)
def _linearised(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    h: Floats,
    sensitivity: Floats,
    gamma: float,
    person: Integers,
    which: Integers,
) -> tuple[Floats, Floats, Integers, Integers]:
    """(margin, jacobian, person, key); see ``Futures.rows``."""
    near = barrier.near_states(h, gamma, barrier.NEAR)
    gradient = body_gradient(capsule, poses, positions, near)
    return barrier.rows_of(h, gradient, sensitivity, gamma, barrier.NEAR, person, which)
