"""The planner's own solver beside IPOPT, one problem at a time; shared by test and benchmark.

Both are started from the motion along the reference, or from the last plan.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control import LocalProblem, Motion, OptimalControl, SsMpcDcbf
from cohelm.control.warm_start import followed
from cohelm.geometry import transform
from cohelm.testing.oracle import OracleSolution, solve
from cohelm.testing.problems import RandomProblem

_ENOUGH = 60
_TIGHT = 1e-6
_SAME = 0.01
"""Costs that differ by less than this share (and 1e-3) are the same optimum."""


class Verdict(StrEnum):
    """Our optimum, from our own seed, against IPOPT's."""

    SAME = "same"
    BETTER = "better"
    OTHER = "other"
    """A dearer one that is an optimum all the same: IPOPT, started there, stays."""
    DEARER = "dearer"
    """IPOPT, started there, ends lower: we stalled, or it went on into another valley."""
    UNSOLVED = "unsolved"
    """IPOPT itself gave up, and there is nothing to compare with."""


@value
class Comparison:
    """Costs of one problem, slack's price included."""

    verdict: Verdict
    oracle: float
    """IPOPT's cost by its own account."""
    there: float
    """IPOPT's solution by our account."""
    kept: float
    """What is left of it after our solver ran from there to convergence."""
    ours: float
    """From our own seed to convergence."""
    budget: float
    """From our own seed within the planner's budget of iterations."""
    exact: bool
    """Whether the distance field repeats the half-planes along IPOPT's solution, to 1e-4 m."""


def compare(drawn: RandomProblem, planner: SsMpcDcbf) -> Comparison:
    """Both solvers on one problem, to convergence.

    Raises:
        ModuleNotFoundError: without CasADi.
    """
    problem, p = drawn.problem, planner.parameters
    found = solve(problem, planner.control, drawn.half_planes)
    there = _motion(problem, found)
    kept = planner.control.solve(problem, there, iterations=_ENOUGH, tolerance=_TIGHT)
    seed = along(problem, there.last_input)
    ours = planner.control.solve(problem, seed, iterations=_ENOUGH, tolerance=_TIGHT)
    budget = planner.control.solve(problem, seed, iterations=p.iterations)
    cost = ours.value.merit
    return Comparison(
        verdict=_verdict(drawn, planner, found, ours.motion, cost),
        oracle=found.cost,
        there=planner.control.value(problem, there).merit,
        kept=kept.value.merit,
        ours=cost,
        budget=budget.value.merit,
        exact=_exact(drawn, there.poses),
    )


def along(problem: LocalProblem, now: Floats) -> Motion:
    """The motion along the reference, as far as the limits let it: a seed that nobody favours."""
    reference = problem.reference
    turn = np.diff(reference.poses[:, 2]) / reference.step
    return followed(problem, np.column_stack([reference.speeds[:-1], turn]), now)


@value
class FirstCommand:
    """The first command (v, ω) of one problem, from one warm start."""

    budget: Annotated[Floats, Shape("2")]
    """After the iterations that were asked for."""
    converged: Annotated[Floats, Shape("2")]
    """After going on from there to convergence: the optimum of the same valley."""
    oracle: Annotated[Floats, Shape("2")]
    """IPOPT's, from the same warm start."""
    verdict: Verdict
    """The converged optimum against IPOPT's, by cost."""


def first_command(
    problem: LocalProblem,
    control: OptimalControl,
    half_planes: Floats,
    seed: Motion,
    *,
    iterations: int = 3,
) -> FirstCommand:
    """Few iterations, many, and IPOPT, all from the same warm start.

    Raises:
        ModuleNotFoundError: without CasADi.
    """
    few = control.solve(problem, seed, iterations=iterations)
    many = control.solve(problem, few.motion, iterations=_ENOUGH, tolerance=_TIGHT)
    found = solve(problem, control, half_planes, last_input=seed.last_input, start=seed.inputs)
    return FirstCommand(
        budget=few.motion.inputs[0],
        converged=many.motion.inputs[0],
        oracle=found.inputs[0],
        verdict=_by_cost(found, many.value.merit) or Verdict.OTHER,
    )


def _motion(problem: LocalProblem, found: OracleSolution) -> Motion:
    poses = problem.robot.motion.rollout(problem.pose, found.inputs, problem.reference.step)
    now = problem.robot.motion.input(problem.twist)
    return Motion(step=problem.reference.step, poses=poses, inputs=found.inputs, last_input=now)


def _verdict(
    drawn: RandomProblem, planner: SsMpcDcbf, found: OracleSolution, ours: Motion, cost: float
) -> Verdict:
    clear = _by_cost(found, cost)
    if clear is not None:
        return clear
    again = solve(drawn.problem, planner.control, drawn.half_planes, start=ours.inputs)
    stays = again.solved and again.cost >= cost - _SAME * cost - 1e-3
    return Verdict.OTHER if stays else Verdict.DEARER


def _by_cost(found: OracleSolution, cost: float) -> Verdict | None:
    """None where ours is dearer, and it has to be found out why."""
    if not found.solved:
        return Verdict.UNSOLVED
    if cost < found.cost - _SAME * found.cost - 1e-3:
        return Verdict.BETTER
    return Verdict.SAME if cost <= found.cost + _SAME * found.cost + 1e-3 else None


def _exact(drawn: RandomProblem, poses: Floats) -> bool:
    centres = transform(poses[:, None, :], drawn.problem.robot.discs[:, :2])
    planes = drawn.half_planes
    truth = (centres @ planes[:, :2].T - planes[:, 2]).min(axis=-1)
    return bool(np.abs(drawn.problem.walls.at(centres) - truth).max() < 1e-4)
