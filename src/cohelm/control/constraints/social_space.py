"""Respect personal space: the dynamic control barrier of Xu et al., eqs. (8) and (9)."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.futures import Futures, Margin, Surroundings, futures
from cohelm.control.constraints.separation import (
    coefficients,
    greatest_reach,
    social_barrier,
    social_gradient,
)


class SocialSpace:
    """h = ‖c − p_i‖ − r_body − r_i − l_i − l at predicted positions; see ``separation``.

    The robot's own reach l depends on its speed, which is decided here; it is frozen at the
    measured speed within a solve.
    """

    class Parameters(Model):
        """Barrier and price, assumed: small, because in a narrow corridor it must yield."""

        gamma: float = Field(0.15, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        distance: Literal["bodies", "printed"] = "bodies"
        """Between footprint and body, or between their centres as printed."""
        growth: float = Field(0.0, ge=0.0)
        """How a space grows with prediction time, m/s."""
        deviations: float = Field(0.0, ge=0.0, le=5.0)
        """By how many standard deviations of the predicted position a space grows."""
        greatest: float = Field(0.3, ge=0.0)
        """The most that a space grows, m."""
        at_least: float = Field(0.3, ge=0.0, le=1.0)
        """Probability from which on a future binds; a person's likeliest always does."""
        l1: float = Field(4.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(4.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "social_space"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = Margin(growth=p.growth, deviations=p.deviations, most=p.greatest)

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By person, the worst over futures and steps, (n,)."""
        s, eggs = problem.spaces, self._eggs(problem)
        who = eggs.who
        h = social_barrier(
            eggs.capsule,
            motion.poses,
            who.positions,
            eggs.kept,
            s.kind,
            eggs.axis,
            eggs.shape,
            s.floor,
            eggs.robot,
            s.robot_floor,
        )
        return who.measure(h, self.parameters.gamma)

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        s, eggs, gamma = problem.spaces, self._eggs(problem), self.parameters.gamma
        gradient = social_gradient(
            eggs.capsule,
            motion.poses,
            eggs.who.positions,
            s.kind,
            eggs.axis,
            eggs.shape,
            s.floor,
            eggs.robot,
            s.robot_floor,
            barrier.near_states(measure.h, gamma, barrier.NEAR),
        )
        return eggs.who.rows(measure.h, gradient, sensitivity, gamma)

    def _eggs(self, problem: LocalProblem) -> _Eggs:
        p = self.parameters
        return _eggs(problem, p.at_least, self._margin, p.gamma, p.distance == "bodies")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Eggs:
    """The spaces of the futures that bind."""

    who: Futures
    capsule: Annotated[Floats, Shape("5")]
    """``Robot.capsule``, or the point that the robot is as printed."""
    kept: Annotated[Floats, Shape("q N+1")]
    """As in ``Futures``; without the body's radius as printed."""
    axis: Annotated[Floats, Shape("q N+1 2")]
    """Unit vectors."""
    shape: Annotated[Floats, Shape("q N+1 3")]
    """``coefficients``; so is the next."""
    robot: Annotated[Floats, Shape("3")]


@functools.lru_cache(maxsize=16)
def _eggs(
    problem: LocalProblem, at_least: float, margin: Margin, gamma: float, bodies: bool
) -> _Eggs:
    """The spaces of a problem, worked out once for all motions that are tried."""
    return _eggs_of(Surroundings(problem), at_least, margin, gamma, bodies)


@functools.lru_cache(maxsize=16)
def _eggs_of(
    surroundings: Surroundings, at_least: float, margin: Margin, gamma: float, bodies: bool
) -> _Eggs:
    problem = surroundings.problem
    s = problem.spaces
    reach = greatest_reach(s.kind, s.scale, s.front, s.side, s.rear, s.floor)
    mine = (s.robot[:1], s.robot[1:2], s.robot[2:])
    reach += greatest_reach(s.kind, s.scale, *mine, s.robot_floor)
    who = futures(problem, at_least, margin, gamma, reach)
    axis, front, side, rear = (
        part.reshape(who.every, part.shape[2])[who.which]
        for part in (s.axis, s.front, s.side, s.rear)
    )
    radius = problem.people.radius[who.person][:, None]
    return _Eggs(
        who=who,
        capsule=problem.robot.capsule if bodies else np.zeros(5),
        kept=who.kept if bodies else who.kept - radius,
        axis=np.stack([np.cos(axis), np.sin(axis)], axis=-1),
        shape=coefficients(s.kind, s.scale, front, side, rear),
        robot=coefficients(s.kind, s.scale, *s.robot),
    )
