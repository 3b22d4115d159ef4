"""Time of solving, beside IPOPT and PIQP on the same states."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.solver import oracle
from cohelm.benchmarks.solver.comparison import along
from cohelm.benchmarks.solver.programs import (
    QuadraticProgram,
    minimise,
    program_at,
    program_workspace,
)
from cohelm.benchmarks.solver.states import TICKS, RideState, ride, with_futures
from cohelm.control import LocalProblem, SsMpcDcbf, Trajectory, qp
from cohelm.control.daqp_call import daqp_addresses
from cohelm.errors import ControlError
from cohelm.stopwatch import Stopwatch, Timing
from cohelm.testing.problems import random_problem

PLAN, PLAN_2 = "plan, 1 candidate", "plan, default"
PLAN_6 = "plan, 3 hypotheses, 2 candidates"
SOLVE, SOLVE_6 = "SQP", "SQP, 3 hypotheses, 2 candidates"
IPOPT, DAQP, PIQP = "CasADi + IPOPT", "QP: DAQP", "QP: PIQP"
AGREE = 1e-4
"""Largest relative difference of two QP solvers' objectives that agree."""

_NONE = 1e5
"""Bounds beyond this are dropped: they would disturb an interior-point method."""


@functools.cache
def warm_up(parameters: SsMpcDcbf.Parameters, horizon: int, ticks: int = TICKS) -> None:
    """Ride and solve so that every branch is compiled before times are counted.

    Args:
        parameters: of the planner.
        horizon: N.
        ticks: of each ride; with fewer, a branch may be compiled while it is timed.

    Code is compiled per array layout: no person, one and many are three of them, and so is a
    horizon as long as the lookahead.
    """
    planner, other = planner_of(parameters, horizon, 1), planner_of(parameters, horizon, 2)
    rng = np.random.default_rng(1)
    for k in range(6):
        drawn = random_problem(
            rng, (0, 1, 5)[k % 3], steps=planner.steps, step=planner.step, hopeless=k < 3
        )
        for state in islice(ride(planner, drawn, horizon), ticks):
            near = state.problem.truncated(horizon)
            planner.control.solve(near, state.seed, iterations=1)
            _two_of_three(planner, with_futures(near), state.seed)
            other.plan(with_futures(state.problem.truncated(other.steps)), state.previous)
            other.plan(state.problem.truncated(other.steps), state.previous)


def planner_of(parameters: SsMpcDcbf.Parameters, horizon: int, candidates: int) -> SsMpcDcbf:
    """Planner with another N and number of optimised candidates.

    With one candidate it is the plain MPC of the paper: it samples only where that fails.
    """
    return SsMpcDcbf(parameters.model_copy(update={"steps": horizon, "candidates": candidates}))


class StateSet(NamedTuple):
    """States along rides on which all solvers are timed."""

    people: int
    horizon: int
    """N; the planner's lookahead is longer."""
    seed: int
    states: int
    """Number of states, 40 per ride."""


def rows(parameters: SsMpcDcbf.Parameters, chosen: StateSet, *, every: int) -> Iterator[Any]:
    """One row per kind of solver; IPOPT solves every ``every``-th state, from the same start."""
    people, horizon, seed, count = chosen
    planner, states = planner_of(parameters, horizon, 1), list[RideState]()
    rng = np.random.default_rng((seed, people))
    while len(states) < count:
        drawn = random_problem(rng, people, steps=planner.steps, step=planner.step)
        states += islice(ride(planner, drawn, horizon), count - len(states))
    near = [(state.problem.truncated(horizon), state.seed) for state in states]
    three = [(with_futures(problem), start) for problem, start in near]
    budget = planner.parameters.iterations
    calls: dict[str, Callable[[int], Any]] = {
        SOLVE: lambda k: planner.control.solve(*near[k], iterations=budget),
        SOLVE_6: lambda k: _two_of_three(planner, *three[k]),
    }
    yield _row(PLAN, people, horizon, np.array([state.time for state in states]), 0)
    for name, call in calls.items():
        yield _row(name, people, horizon, *_timed(call, len(states)))
    yield _row(
        PLAN_2,
        people,
        horizon,
        *_plans(planner_of(parameters, horizon, parameters.candidates), states),
    )
    yield _row(
        PLAN_6, people, horizon, *_plans(planner_of(parameters, horizon, 2), states, with_futures)
    )
    yield from _programs(planner, near[::every], people, horizon)
    if find_spec("casadi"):
        yield _ipopt(planner, states[::every], people, horizon)


def _two_of_three(planner: SsMpcDcbf, problem: LocalProblem, seed: Trajectory) -> None:
    for start in (seed, along(problem, seed.current_input)):
        planner.control.solve(problem, start, iterations=planner.parameters.iterations)


def _plans(
    planner: SsMpcDcbf,
    states: list[RideState],
    changed: Callable[[LocalProblem], LocalProblem] = lambda problem: problem,
) -> tuple[Floats, int]:
    problems = [changed(state.problem.truncated(planner.steps)) for state in states]
    return _timed(lambda k: planner.plan(problems[k], states[k].previous), len(states))


def _timed(call: Callable[[int], Any], count: int) -> tuple[Floats, int]:
    """(thread CPU times, s; how many failed)."""
    times, failed = np.empty(count), 0
    for k in range(count):
        watch = Stopwatch()
        try:
            call(k)
        except ControlError:
            failed += 1
        times[k] = watch.elapsed()
    return times, failed


def _ipopt(planner: SsMpcDcbf, states: list[RideState], people: int, horizon: int) -> Any:
    times, failed = [], 0
    for state in states:
        found = oracle.solve(
            state.problem.truncated(horizon),
            planner.control,
            state.half_planes,
            current_input=state.seed.current_input,
            start=state.seed.inputs,
        )
        times.append(found.time)
        failed += not found.solved
    return _row(IPOPT, people, horizon, np.array(times), failed)


def _programs(
    planner: SsMpcDcbf, near: list[tuple[LocalProblem, Trajectory]], people: int, horizon: int
) -> Iterator[Any]:
    """Quadratic programs of first steps, cold, by both solvers; complete for PIQP."""
    daqp, failed, times, failed_piqp, agree = list[float](), 0, list[float](), 0, 0
    for problem, start in near:
        prepared = planner.control.prepare(problem, start.current_input)
        program = program_at(prepared, start.inputs)
        like = planner.control.space(prepared.scene, prepared.objective)
        minimise(program, like)  # the first call from here loads the kernel
        space = program_workspace(program, like)
        watch = Stopwatch()
        failed += qp.minimise(daqp_addresses(), space, len(program.margin)) < 1
        daqp.append(watch.elapsed())
        if find_spec("piqp"):
            seconds, theirs = piqp(program)
            times.append(seconds)
            failed_piqp += theirs is None
            if theirs is not None:
                ours = program.objective(space.program.z[: len(program.gradient)])
                other = program.objective(theirs)
                agree += abs(ours - other) <= AGREE * (1.0 + abs(other))
    yield _row(DAQP, people, horizon, np.array(daqp), failed)
    if times:
        row = _row(PIQP, people, horizon, np.array(times), failed_piqp)
        yield {**row, "agree": agree}


def piqp(program: QuadraticProgram) -> tuple[float, Floats | None]:
    """Solve the complete program by PIQP, set-up included: (thread CPU time, s; x or None).

    Its variables are x and all slacks.
    """
    solver = importlib.import_module("piqp").DenseSolver()
    n, slacks = len(program.gradient), len(program.l1)
    watch = Stopwatch()
    hessian = np.zeros((n + slacks, n + slacks), order="F")
    hessian[:n, :n] = program.hessian
    hessian[range(n, n + slacks), range(n, n + slacks)] = program.l2
    rows_ = np.zeros((len(program.margin), n + slacks), order="F")
    rows_[:, :n] = program.jacobian
    soft = np.flatnonzero(program.slack >= 0)
    rows_[soft, n + program.slack[soft]] = 1.0
    solver.setup(
        hessian,
        np.concatenate([program.gradient, program.l1]),
        None,
        None,
        rows_,
        -program.margin,
        np.where(program.upper < _NONE, program.upper, np.inf),
        np.concatenate([program.low, np.zeros(slacks)]),
        np.concatenate([program.high, np.full(slacks, np.inf)]),
    )
    status = solver.solve()
    seconds = watch.elapsed()
    solved = status == importlib.import_module("piqp").PIQP_SOLVED
    return seconds, np.array(solver.result.x)[:n] if solved else None


def _row(what: str, people: int, horizon: int, seconds: Floats, failed: int) -> Mapping[str, Any]:
    timing = Timing.of(seconds)
    return {
        "part": "speed",
        "people": people,
        "horizon": horizon,
        "what": what,
        "solves": timing.rounds,
        "median_ms": timing.median,
        "p99_ms": timing.p99,
        "max_ms": timing.maximum,
        "failed": failed,
    }
