"""The planner's solver compared with IPOPT, one problem at a time; for tests and benchmarks.

Both start from the trajectory along the reference, or from the last plan.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.benchmarks.solver.oracle import OracleSolution, solve
from cohelm.control import LocalProblem, OptimalControl, SsMpcDcbf, Trajectory
from cohelm.control.trajectories import limited_trajectory
from cohelm.geometry import transform
from cohelm.testing.problems import RandomProblem

_ENOUGH = 60
_TIGHT = 1e-6
_SAME = 0.01
"""Costs that differ by less than this share (and 1e-3) are the same optimum."""


class OptimumVerdict(StrEnum):
    """Our optimum, from our own start, compared with IPOPT's."""

    SAME = "same"
    BETTER = "better"
    OTHER = "other"
    """A higher cost that is an optimum all the same: IPOPT, started there, stays."""
    HIGHER = "higher"
    """IPOPT, started there, ends lower: we stalled, or it moved to another local optimum."""
    UNSOLVED = "unsolved"
    """IPOPT itself failed, and there is nothing to compare with."""


@value
class SolverComparison:
    """Costs of one problem, prices of the barriers included, s."""

    verdict: OptimumVerdict
    oracle: float
    """Cost of IPOPT's solution, evaluated by IPOPT."""
    there: float
    """Cost of IPOPT's solution, evaluated by us."""
    kept: float
    """Cost after our solver has run from IPOPT's solution to convergence."""
    ours: float
    """Cost from our own start, converged."""
    budget: float
    """Cost from our own start within the planner's number of iterations."""
    exact: bool
    """True where both have the same problem along IPOPT's solution: the distance field equals the
    half-planes, to 1e-4 m, and each state lies on the segment of the path that IPOPT was given."""


def compare(drawn: RandomProblem, planner: SsMpcDcbf) -> SolverComparison:
    """Run both solvers on one problem to convergence.

    Raises:
        ModuleNotFoundError: without CasADi.
    """
    problem, p = drawn.problem, planner.parameters
    found = solve(problem, planner.control, drawn.half_planes)
    there = _trajectory(problem, found)
    kept = planner.control.solve(problem, there, iterations=_ENOUGH, tolerance=_TIGHT)
    seed = along(problem, there.current_input)
    ours = planner.control.solve(problem, seed, iterations=_ENOUGH, tolerance=_TIGHT)
    budget = planner.control.solve(problem, seed, iterations=p.iterations)
    cost = ours.evaluation.cost
    return SolverComparison(
        verdict=_verdict(drawn, planner, found, ours.trajectory, cost),
        oracle=found.cost,
        there=planner.control.evaluate(problem, there).cost,
        kept=kept.evaluation.cost,
        ours=cost,
        budget=budget.evaluation.cost,
        exact=found.settled and _same_walls(drawn, there.poses),
    )


def along(problem: LocalProblem, current_input: Floats) -> Trajectory:
    """Motion along the reference, as far as the limits allow: a neutral start."""
    reference = problem.reference
    turn = np.diff(reference.poses[:, 2]) / reference.step
    return limited_trajectory(
        problem, np.column_stack([reference.speeds[:-1], turn]), current_input
    )


@value
class FirstCommand:
    """First command (v, ω) of one problem, from one warm start."""

    budget: Annotated[Floats, Shape("2")]
    """After the requested iterations."""
    converged: Annotated[Floats, Shape("2")]
    """Converged from there: the same local optimum."""
    oracle: Annotated[Floats, Shape("2")]
    """Solution of IPOPT from the same warm start."""
    verdict: OptimumVerdict
    """Converged optimum compared with IPOPT's, by cost."""


def first_command(
    problem: LocalProblem,
    control: OptimalControl,
    half_planes: Floats,
    seed: Trajectory,
    *,
    iterations: int = 3,
) -> FirstCommand:
    """Solve by few iterations, to convergence and by IPOPT, from the same warm start.

    Raises:
        ModuleNotFoundError: without CasADi.
    """
    few = control.solve(problem, seed, iterations=iterations)
    many = control.solve(problem, few.trajectory, iterations=_ENOUGH, tolerance=_TIGHT)
    found = solve(
        problem, control, half_planes, current_input=seed.current_input, start=seed.inputs
    )
    return FirstCommand(
        budget=few.trajectory.inputs[0],
        converged=many.trajectory.inputs[0],
        oracle=found.inputs[0],
        verdict=_by_cost(found, many.evaluation.cost) or OptimumVerdict.OTHER,
    )


def _trajectory(problem: LocalProblem, found: OracleSolution) -> Trajectory:
    poses = problem.robot.motion_model.rollout(problem.pose, found.inputs, problem.reference.step)
    current_input = problem.robot.motion_model.input(problem.twist)
    return Trajectory(
        step=problem.reference.step, poses=poses, inputs=found.inputs, current_input=current_input
    )


def _verdict(
    drawn: RandomProblem, planner: SsMpcDcbf, found: OracleSolution, ours: Trajectory, cost: float
) -> OptimumVerdict:
    clear = _by_cost(found, cost)
    if clear is not None:
        return clear
    again = solve(drawn.problem, planner.control, drawn.half_planes, start=ours.inputs)
    stays = again.solved and again.cost >= cost - _SAME * cost - 1e-3
    return OptimumVerdict.OTHER if stays else OptimumVerdict.HIGHER


def _by_cost(found: OracleSolution, cost: float) -> OptimumVerdict | None:
    """Verdict by cost alone; None where ours is higher, which needs a further test."""
    if not found.solved:
        return OptimumVerdict.UNSOLVED
    if cost < found.cost - _SAME * found.cost - 1e-3:
        return OptimumVerdict.BETTER
    return OptimumVerdict.SAME if cost <= found.cost + _SAME * found.cost + 1e-3 else None


def _same_walls(drawn: RandomProblem, poses: Floats) -> bool:
    centres = transform(poses[:, None, :], drawn.problem.robot.discs[:, :2])
    planes = drawn.half_planes
    truth = (centres @ planes[:, :2].T - planes[:, 2]).min(axis=-1)
    return bool(np.abs(drawn.problem.walls.at(centres) - truth).max() < 1e-4)
