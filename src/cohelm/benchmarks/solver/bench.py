"""Speed and reliability of the local planner's solver, compared with CasADi + IPOPT.

All in one process and in thread CPU time, so that other load on the machine counts little. Four
parts, each of which can be run alone:

``speed``     plans and solves along rides, by people and horizon; IPOPT on some of the same states
              from the same warm start; the first quadratic programs by DAQP and by PIQP;
``optima``    random problems: IPOPT's solution is one of ours, see ``comparison``;
``commands``  along rides: the first command after three warm-started iterations;
``failures``  random, crowded and hopeless states, on which no solve may fail.

Report of ``cohelm bench solver``: one table per part, verdicts, picture of time over people.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.benchmarks.bench import BenchReport, Result, Sheet, Task, known_name
from cohelm.benchmarks.claims import (
    MET,
    MISSED,
    Bound,
    Verdict,
    bounded,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.options import repeatable
from cohelm.benchmarks.solver import correctness, speed
from cohelm.benchmarks.solver.comparison import OptimumVerdict
from cohelm.benchmarks.solver.correctness import NEAR
from cohelm.benchmarks.solver.speed import IPOPT, PLAN, PLAN_2, PLAN_6, SOLVE, SOLVE_6
from cohelm.benchmarks.solver.states import TICKS, planner_with
from cohelm.control import SsMpcDcbf
from cohelm.messages import Status
from cohelm.plotting import canvas
from cohelm.plotting.route_panels import STYLES

HORIZON = 25
"""Horizon at which times are judged."""
FASTER = {1: Bound(low=10.0), 20: Bound(low=30.0)}
"""People → required ratio of IPOPT's time to that of a plan."""
TIMES = {PLAN: (2.0, 5.0), SOLVE_6: (6.0, 15.0), PLAN_6: (6.0, 15.0)}
"""Allowed (median, p99) among ``CROWD`` people on a quiet core, ms."""
CROWD, LARGEST = 20, 50
LINEAR, TOLERANCE = (1, 20), 0.1
"""The times among so many people, from and to, define a line; the time among ``LARGEST`` may exceed
it by this share."""
NEAR_SHARE = Bound(low=0.95)
"""Share of the states in which the first command has to be that of the optimum."""
DRAWN = (IPOPT, PLAN_6, PLAN_2, SOLVE_6, PLAN, SOLVE)
_COMPARED = (PLAN, PLAN_2, SOLVE)

Rows = Sequence[Mapping[str, Any]]


def solver_report(rows: Rows, folder: Path) -> BenchReport:
    """Tables, verdicts and the picture."""
    sheets: list[Sheet] = []
    verdicts: list[Verdict] = []
    for part, (sheet, judge) in _PARTS.items():
        found = [row for row in rows if row["part"] == part and "remark" not in row]
        if found:
            sheets.append(sheet(found))
            verdicts += judge(found)
    remarks = dict.fromkeys(str(row["remark"]) for row in rows if "remark" in row)
    speed = [row for row in rows if row["part"] == "speed"]
    return BenchReport(
        sheets=(*sheets, verdict_sheet(verdicts)),
        notes=(*remarks, *verdict_notes(verdicts)),
        summary={"verdicts": verdict_summary(verdicts)},
        files=(draw_speed(speed, HORIZON, folder / "solver.png"),) if speed else (),
    )


def _speed_sheet(rows: Rows) -> Sheet:
    return Sheet(
        title="Thread CPU time; IPOPT ratio: IPOPT's median over this one",
        columns=("N", "people", "", "solves", "median, ms", "p99", "max", "failed", "IPOPT ratio"),
        rows=tuple(
            (
                str(row["horizon"]),
                str(row["people"]),
                row["what"],
                str(row["solves"]),
                *(f"{row[key]:.2f}" for key in ("median_ms", "p99_ms", "max_ms")),
                str(row["failed"]),
                f"{ratio:.0f}" if math.isfinite(ratio := _ratio(rows, row)) else "",
            )
            for row in rows
        ),
    )


def _ratio(rows: Rows, row: Mapping[str, Any]) -> float:
    """IPOPT's median over that of a plan or solve of the same problem."""
    if row["what"] not in _COMPARED:
        return math.nan
    key = (row["people"], row["horizon"])
    theirs = [r for r in rows if r["what"] == IPOPT and (r["people"], r["horizon"]) == key]
    return theirs[0]["median_ms"] / row["median_ms"] if theirs else math.nan


def _speed_verdicts(rows: Rows) -> Iterator[Verdict]:
    here = [row for row in rows if row["horizon"] == HORIZON]
    for row in here:
        what, people, ratio = row["what"], row["people"], _ratio(rows, row)
        subject = f"{what}, {people} people"
        if what == PLAN and people in FASTER and math.isfinite(ratio):
            yield bounded(subject, "IPOPT ratio", ratio, FASTER[people], f"{ratio:.0f}")
        if what in TIMES and people == CROWD:
            for name, limit in zip(("median", "p99"), TIMES[what], strict=True):
                claim, bound = f"{name} on a quiet core, ms", Bound(high=limit)
                yield bounded(subject, claim, row[f"{name}_ms"], bound, f"{row[f'{name}_ms']:.2f}")
    plans = {row["people"]: row["median_ms"] for row in here if row["what"] == PLAN}
    if {*LINEAR, LARGEST} <= plans.keys():
        yield _linear(plans)
    for row in rows:
        if "agree" in row and row["agree"] + row["failed"] < row["solves"]:
            subject = f"QP, N = {row['horizon']}, {row['people']} people"
            yield Verdict(subject, "DAQP and PIQP agree", "no", "yes", MISSED)
    failed = sum(row["failed"] for row in rows if row["what"] in {SOLVE, SOLVE_6, PLAN_2, PLAN_6})
    yield bounded("solves and plans along rides", "failed", failed, Bound(high=0.0))


def _linear(plans: Mapping[int, float]) -> Verdict:
    """Check that time grows at most linearly: the line through fewer people's, extrapolated."""
    known = [people for people in plans if LINEAR[0] <= people <= LINEAR[1]]
    each, none = np.polyfit(known, [plans[people] for people in known], 1)
    limit = (1.0 + TOLERANCE) * (none + each * LARGEST)
    remark = (
        f"{none:.2f} ms + {each:.3f} ms a person from {LINEAR[0]} to {LINEAR[1]} makes "
        f"{none + each * LARGEST:.2f} ms; {TOLERANCE:.0%} more allowed"
    )
    found = plans[LARGEST]
    result = MET if found <= limit else MISSED
    subject, claim = f"{PLAN}, {LARGEST} people", "at most linear in people, ms"
    return Verdict(subject, claim, f"{found:.2f}", f"≤ {limit:.2f}", result, remark)


def _optima_sheet(rows: Rows) -> Sheet:
    def total(key: str) -> str:
        return str(sum(row[key] for row in rows))

    lines = (
        ("random problems, 0 to 20 people", total("problems")),
        ("solved by IPOPT", total("solved")),
        ("of those with the same walls for both, to 0.1 mm", total("exact")),
        ("IPOPT's solution kept, cost within 0.1 %", total("stays")),
        ("largest gain over it, share", f"{max(row['most_gained'] for row in rows):.1e}"),
        (
            "largest error of its cost in our evaluation, share",
            f"{max(row['most_by_account'] for row in rows):.1e}",
        ),
        ("started along the reference: IPOPT's cost, to 1 %", total(OptimumVerdict.SAME)),
        ("a lower one", total(OptimumVerdict.BETTER)),
        ("another local optimum, where IPOPT stays too", total(OptimumVerdict.OTHER)),
        ("a higher one, from where IPOPT ends lower", total(OptimumVerdict.HIGHER)),
    )
    return Sheet(title="Optima beside IPOPT's", columns=("", ""), rows=lines)


def _optima_verdicts(rows: Rows) -> Iterator[Verdict]:
    stays, exact = (sum(row[key] for row in rows) for key in ("stays", "exact"))
    result = MET if stays == exact else MISSED
    yield Verdict("optima", "IPOPT's solution kept", f"{stays} of {exact}", "all", result)


def _commands_sheet(rows: Rows) -> Sheet:
    lines = []
    for people in sorted({row["people"] for row in rows}):
        some = [row for row in rows if row["people"] == people]
        count = Counter(row["verdict"] for row in some)
        same = [row for row in some if row["verdict"] == OptimumVerdict.SAME]
        lines.append(
            (
                str(people),
                str(len(some)),
                str(sum(row["near_converged"] for row in some)),
                f"{sum(row['near_oracle'] for row in same)} of {len(same)}",
                str(count[OptimumVerdict.BETTER]),
                str(count[OptimumVerdict.OTHER]),
                str(count[OptimumVerdict.UNSOLVED]),
            )
        )
    return Sheet(
        title="First command after three iterations, within "
        f"{NEAR[0]:g} m/s and {NEAR[1]:g} rad/s; IPOPT from the same warm start",
        columns=(
            "people",
            "states",
            "of our own optimum",
            "of IPOPT's, at equal cost",
            "IPOPT's cost higher",
            "IPOPT's cost lower",
            "unsolved",
        ),
        rows=tuple(lines),
    )


def _commands_verdicts(rows: Rows) -> Iterator[Verdict]:
    share = sum(row["near_converged"] for row in rows) / len(rows)
    claim = "first command is that of the optimum, share"
    yield bounded("commands", claim, share, NEAR_SHARE, f"{share:.3f}")


def _failures_sheet(rows: Rows) -> Sheet:
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    keys = ("solves", "failed", "plans", "plans_failed", "ok", "relaxed", "stop")
    return Sheet(
        title="States on which no solve may fail",
        columns=("", *(key.replace("_", " ") for key in keys)),
        rows=tuple(
            (kind, *(str(sum(row[key] for row in rows if row["kind"] == kind)) for key in keys))
            for kind in kinds
        ),
    )


def _failures_verdicts(rows: Rows) -> Iterator[Verdict]:
    failed = sum(row["failed"] + row["plans_failed"] for row in rows)
    solves = sum(row["solves"] + row["plans"] for row in rows)
    found = f"{failed} in {solves} solves and plans"
    yield bounded("failures", "failed", failed, Bound(high=0.0), found)


_PARTS = {
    "speed": (_speed_sheet, _speed_verdicts),
    "optima": (_optima_sheet, _optima_verdicts),
    "commands": (_commands_sheet, _commands_verdicts),
    "failures": (_failures_sheet, _failures_verdicts),
}


def draw_speed(rows: Rows, horizon: int, file: Path) -> Path:
    """Draw the median times over people on a logarithmic scale, p99 dotted.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = Figure(figsize=(6.4, 3.8), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for what, (colour, _, _) in zip(DRAWN, STYLES, strict=False):
        line = sorted(
            (row["people"], row["median_ms"], row["p99_ms"])
            for row in rows
            if (row["what"], row["horizon"]) == (what, horizon)
        )
        if line:
            people, median, p99 = zip(*line, strict=True)
            axes.plot(people, median, color=colour, marker="o", markersize=3, label=what)
            axes.plot(people, p99, color=colour, linestyle=":", linewidth=1)
    axes.set_yscale("log")
    axes.set(xlabel="people", ylabel="thread CPU time, ms")
    axes.set_title(f"N = {horizon}, walls included: median, and p99 dotted", fontsize=9)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=8)
    canvas.save(figure, file)
    return file


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
    parts: Annotated[
        tuple[str, ...],
        repeatable("--part", "NAME", "speed, optima, commands or failures; default: all"),
    ] = (),
    share: Annotated[
        float, typer.Option(min=0.001, max=100.0, help="Share of the usual number of states.")
    ] = 1.0,
    settings: Annotated[
        tuple[str, ...],
        repeatable("--set", "KEY=VALUE", "Parameter of the planner: local_planner.iterations=5"),
    ] = (),
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
