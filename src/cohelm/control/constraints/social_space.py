"""Respect personal space: the dynamic control barrier of Xu et al., eqs. (8) and (9)."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape
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
from cohelm.shapes import ELLIPSE


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
        return who.measure(
            *_measured(
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
                self.parameters.gamma,
                who.person,
                who.people,
            )
        )

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        s, eggs = problem.spaces, self._eggs(problem)
        who = eggs.who
        return who.rows(
            measure.h,
            *_linearised(
                eggs.capsule,
                motion.poses,
                who.positions,
                s.kind,
                eggs.axis,
                eggs.shape,
                s.floor,
                eggs.robot,
                s.robot_floor,
                measure.h,
                sensitivity,
                self.parameters.gamma,
                who.person,
                who.which,
            ),
        )

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
    robot, mine = _robot(s.kind, s.scale, tuple(s.robot.tolist()), s.robot_floor)
    who = futures(problem, at_least, margin, gamma, reach + mine)
    axis, shape = _of_futures(s.kind, s.scale, s.axis, s.front, s.side, s.rear, who.which)
    kept = who.kept if bodies else who.kept - problem.people.radius[who.person][:, None]
    return _Eggs(
        who=who,
        capsule=problem.robot.capsule if bodies else np.zeros(5),
        kept=kept,
        axis=axis,
        shape=shape,
        robot=robot,
    )


@functools.lru_cache(maxsize=64)
def _robot(kind: int, scale: float, sigma: tuple[float, ...], floor: float) -> tuple[Floats, float]:
    """(``coefficients`` of the robot's own space, its greatest reach)."""
    front, side, rear = (np.array([part]) for part in sigma)
    egg = coefficients(kind, scale, front, side, rear)[0]
    return egg, greatest_reach(kind, scale, front, side, rear, floor)


@njit(cache=True)
def _of_futures(  # noqa: PLR0917  # a kernel takes plain arrays
    kind: int,
    scale: float,
    axis: Floats,
    front: Floats,
    side: Floats,
    rear: Floats,
    which: Integers,
) -> tuple[Floats, Floats]:
    """(axes (q, N+1, 2), ``coefficients`` (q, N+1, 3)) of some of the futures; see ``_Eggs``."""
    hypotheses, states = max(axis.shape[1], 1), axis.shape[2]
    unit, shape = np.empty((len(which), states, 2)), np.empty((len(which), states, 3))
    for q in range(len(which)):
        i, j = which[q] // hypotheses, which[q] % hypotheses
        for k in range(states):
            unit[q, k, 0], unit[q, k, 1] = math.cos(axis[i, j, k]), math.sin(axis[i, j, k])
            ahead, aside = front[i, j, k], side[i, j, k]
            behind = ahead if kind == ELLIPSE else rear[i, j, k]
            shape[q, k, 0] = 0.5 / (scale * ahead * ahead)
            shape[q, k, 1] = 0.5 / (scale * behind * behind)
            shape[q, k, 2] = 0.5 / (scale * aside * aside)
    return unit, shape


@njit(cache=True)
def _measured(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    kept: Floats,
    kind: int,
    axis: Floats,
    eggs: Floats,
    floor: float,
    robot: Floats,
    robot_floor: float,
    gamma: float,
    person: Integers,
    people: int,
) -> tuple[Floats, Floats, float]:
    """(h, slack, the smallest h); see ``Futures.measure``."""
    h = social_barrier(capsule, poses, positions, kept, kind, axis, eggs, floor, robot, robot_floor)
    slack, smallest = barrier.worst_of(h, gamma, person, people)
    return h, slack, smallest


@njit(cache=True)
def _linearised(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    kind: int,
    axis: Floats,
    eggs: Floats,
    floor: float,
    robot: Floats,
    robot_floor: float,
    h: Floats,
    sensitivity: Floats,
    gamma: float,
    person: Integers,
    which: Integers,
) -> tuple[Floats, Floats, Integers, Integers]:
    """(margin, jacobian, person, key); see ``Futures.rows``."""
    near = barrier.near_states(h, gamma, barrier.NEAR)
    gradient = social_gradient(
        capsule, poses, positions, kind, axis, eggs, floor, robot, robot_floor, near
    )
    return barrier.rows_of(h, gradient, sensitivity, gamma, barrier.NEAR, person, which)
