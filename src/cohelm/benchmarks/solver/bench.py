"""Speed and reliability of the local planner's solver, compared with CasADi + IPOPT.

All in one process and in thread CPU time, so that other load on the machine counts little. Four
parts, each of which can be run alone:

``speed``     plans and solves along rides, by people and horizon; IPOPT on some of the same states
              from the same warm start; the first quadratic programs by DAQP and by PIQP;
``optima``    random problems: IPOPT's solution is one of ours, see ``comparison``;
``commands``  along rides: the first command after three warm-started iterations;
``failures``  random, crowded and hopeless states, on which no solve may fail.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name
from cohelm.benchmarks.solver import correctness, speed
from cohelm.benchmarks.solver.report import solver_report
from cohelm.benchmarks.solver.states import TICKS, planner_with
from cohelm.control import SsMpcDcbf
from cohelm.messages import Status
from cohelm.testing.comparison import OptimumVerdict

TITLE = "The local planner's solver compared with CasADi + IPOPT"
PARTS = ("speed", "optima", "commands", "failures")
PEOPLE = (0, 1, 5, 10, 20, 30, 50)
HORIZONS = (25, 10, 40)
RIDES, EVERY = 8, 16
"""Rides of each crowd and horizon; IPOPT solves every ``EVERY``-th state."""
STATES = RIDES * TICKS
"""States of each crowd and horizon."""
PROBLEMS, SOLVES = 500, 21_000
"""Random problems for the optima; solves that may not fail."""
MAX_PEOPLE = 20
"""Largest crowd in which first commands are compared."""
NO_ORACLE = "CasADi is not installed: pip install cohelm[bench]"
COLUMNS = (
    *("part", "people", "horizon", "what", "kind", "solves", "median_ms", "p99_ms", "max_ms"),
    *("failed", "agree", "plans", "plans_failed", *(status.value for status in Status)),
    *("problems", "solved", "exact", "stays", "most_gained", "most_by_account"),
    *(verdict.value for verdict in OptimumVerdict),
    *("verdict", "off_v", "off_w", "near_converged", "near_oracle", "remark"),
)

_CHUNK, _SOLVES = 50, 1500  # problems, solves per task: what an interrupt loses


@dataclass(frozen=True)
class SolverBench:
    """The benchmark, or a share of some of its parts."""

    parts: tuple[str, ...] = PARTS
    share: float = 1.0
    settings: tuple[str, ...] = ()
    """``local_planner.parameter=value``."""
    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """Small tasks; every seed gives other states."""
        out: list[Task] = []
        for seed in seeds:
            out += [t for t in self._all(seed) if t[0] in self.parts]
        return out

    def _all(self, seed: int) -> list[Task]:
        rides = max(round(RIDES * self.share), 1)
        states = max(round(STATES * self.share), 1)
        chunks = max(round(PROBLEMS * self.share / _CHUNK), 1)
        problems = max(round(PROBLEMS * self.share / chunks), 1)
        kinds = correctness.KINDS
        runs = max(round(SOLVES * self.share / _SOLVES / len(kinds)), 1)
        solves = max(round(SOLVES * self.share / runs / len(kinds)), 1)
        return [
            *(("speed", n, horizon, states, seed) for horizon in HORIZONS for n in PEOPLE),
            *(("optima", problems, 1000 * seed + k) for k in range(chunks)),
            *(("commands", n, max(rides // 2, 1), seed) for n in PEOPLE if n <= MAX_PEOPLE),
            *(("failures", kind, solves, 1000 * seed + k) for kind in kinds for k in range(runs)),
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Rows of one task."""
        return [
            Result({column: row.get(column, math.nan) for column in COLUMNS})
            for row in _rows(task, planner_with(self.settings))
        ]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per part, verdicts, time over people as a picture."""
        rows = [{k: v for k, v in r.row.items() if not _absent(v)} for r in results]
        return solver_report(rows, folder)


def create(
    parts: Sequence[str] = (), share: float = 1.0, settings: Sequence[str] = ()
) -> SolverBench:
    """Create the benchmark with some parts, a share of its states, the planner with settings.

    Raises:
        ConfigError: if there is no such part, or the planner has no such parameter.
    """
    planner_with(settings)
    for part in parts:
        known_name(part, PARTS, "part", "--part")
    return SolverBench(tuple(parts) or PARTS, share, tuple(settings))


def _rows(task: Task, planner: SsMpcDcbf) -> Iterable[Mapping[str, Any]]:
    part, *rest = task
    if part == "speed":
        people, horizon, states, seed = rest
        speed.warm_up(planner.parameters, horizon, min(states, TICKS))
        return speed.rows(
            planner.parameters, speed.StateSet(people, horizon, seed, states), every=EVERY
        )
    if part == "failures":
        kind, solves, seed = rest
        return [correctness.failures(kind, solves, seed, planner=planner)]
    if not find_spec("casadi"):
        return [{"part": part, "remark": NO_ORACLE}]
    if part == "optima":
        count, seed = rest
        return [correctness.optima(count, seed, planner=planner)]
    people, rides, seed = rest
    return correctness.commands(people, rides, 2, seed, planner=planner)


def _absent(content: Any) -> bool:
    return isinstance(content, float) and math.isnan(content)
