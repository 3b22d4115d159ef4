"""What the rows of ``cohelm bench solver`` say."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.evaluation.benches.bench import Report, Sheet
from cohelm.testing.benches.solver_proofs import NEAR
from cohelm.testing.benches.solver_speed import IPOPT, PLAN, PLAN_2, PLAN_6, SOLVE, SOLVE_6
from cohelm.testing.comparison import Verdict

HORIZON = 25
"""What is asked of times holds there."""
LEAST_RATIO = {1: 10.0, 20: 30.0}
"""How many times faster than IPOPT a plan has to be, by people."""
MOST_MS = {PLAN: (2.0, 5.0), SOLVE_6: (6.0, 15.0), PLAN_6: (6.0, 15.0)}
"""(median, p99) that may be taken among 20 people on a quiet core, ms."""
CROWD, GREATEST = 20, 50
LINEAR, TOLERANCE = (1, 20), 0.1
"""The times among so many people, from and to, make the line that time among ``GREATEST`` may not
exceed by more than this share."""
NEAR_SHARE = 0.95
"""Of the states, where the first command has to be that of the optimum."""


def report(rows: Sequence[Any]) -> Report:
    """Tables and sentences."""
    parts = {part: [row for row in rows if row["part"] == part] for part in _SHEETS}
    sheets, notes = [], []
    for part, (sheet, verdicts) in _SHEETS.items():
        told = [row for row in parts[part] if "remark" not in row]
        notes += [row["remark"] for row in parts[part] if "remark" in row]
        if told:
            sheets.append(sheet(told))
            notes += verdicts(told)
    return Report(tuple(sheets), tuple(dict.fromkeys(notes)), {})


def _speeds(rows: Sequence[Any]) -> Sheet:
    columns = ("N", "people", "", "solves", "median, ms", "p99", "max", "failed", "× faster")
    return Sheet(
        title="Thread CPU time; × faster: IPOPT's median over this one's",
        columns=columns,
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


def _ratio(rows: Sequence[Any], row: Any) -> float:
    """IPOPT's median over that of a plan or solve of the same problem."""
    if row["what"] not in {PLAN, PLAN_2, SOLVE}:
        return math.nan
    key = (row["people"], row["horizon"])
    theirs = [r for r in rows if r["what"] == IPOPT and (r["people"], r["horizon"]) == key]
    return theirs[0]["median_ms"] / row["median_ms"] if theirs else math.nan


def _speed_notes(rows: Sequence[Any]) -> Iterator[str]:
    here = [row for row in rows if row["horizon"] == HORIZON]
    for row in here:
        least, ratio = LEAST_RATIO.get(row["people"]), _ratio(rows, row)
        if row["what"] == PLAN and least is not None and math.isfinite(ratio):
            word = _word(ratio >= least)
            who = "1 person" if row["people"] == 1 else f"{row['people']} people"
            yield f"a plan among {who}: {ratio:.0f} times IPOPT, {least:g} asked: {word}"
        if row["what"] in MOST_MS and row["people"] == CROWD:
            median, p99 = MOST_MS[row["what"]]
            word = _word(row["median_ms"] <= median and row["p99_ms"] <= p99)
            yield (
                f"{row['what']} among {CROWD} people: {row['median_ms']:.2f} ms median, "
                f"{row['p99_ms']:.2f} ms p99; {median:g} and {p99:g} asked of a quiet core: {word}"
            )
    plans = {row["people"]: row["median_ms"] for row in here if row["what"] == PLAN}
    if {*LINEAR, GREATEST} <= plans.keys():
        yield _linear(plans)
    for row in rows:
        if "agree" in row and row["agree"] + row["failed"] < row["solves"]:
            yield f"DAQP and PIQP disagree: N = {row['horizon']}, {row['people']} people"
    failed = sum(row["failed"] for row in rows if row["what"] in {SOLVE, SOLVE_6, PLAN_2, PLAN_6})
    yield f"solves and plans along rides that failed: {failed}, 0 asked: {_word(not failed)}"


def _linear(plans: Mapping[int, float]) -> str:
    """Whether time grows at most linearly: the line through fewer people's, drawn on."""
    known = [people for people in plans if LINEAR[0] <= people <= LINEAR[1]]
    each, none = np.polyfit(known, [plans[people] for people in known], 1)
    most = (1.0 + TOLERANCE) * (none + each * GREATEST)
    return (
        f"at most linear in people: {none:.2f} ms + {each:.3f} ms a person from {LINEAR[0]} to "
        f"{LINEAR[1]}, so {none + each * GREATEST:.2f} ms among {GREATEST} and {TOLERANCE:.0%} "
        f"more allowed; it takes {plans[GREATEST]:.2f}: {_word(plans[GREATEST] <= most)}"
    )


def _optima(rows: Sequence[Any]) -> Sheet:
    def total(key: str) -> str:
        return str(sum(row[key] for row in rows))

    lines = (
        ("random problems, 0 to 20 people", total("problems")),
        ("solved by IPOPT", total("solved")),
        ("of those with the same walls for both, to 0.1 mm", total("exact")),
        ("IPOPT's solution kept, cost within 0.1 %", total("stays")),
        ("most gained from it, share", f"{max(row['most_gained'] for row in rows):.1e}"),
        ("its cost by our account, most off", f"{max(row['most_by_account'] for row in rows):.1e}"),
        ("from along the reference: IPOPT's cost, to 1 %", total(Verdict.SAME)),
        ("a lower one", total(Verdict.BETTER)),
        ("another local optimum, where IPOPT stays too", total(Verdict.OTHER)),
        ("a dearer one, from where IPOPT ends lower", total(Verdict.DEARER)),
    )
    return Sheet(title="Optima beside IPOPT's", columns=("", ""), rows=lines)


def _optima_notes(rows: Sequence[Any]) -> Iterator[str]:
    stays, exact = (sum(row[key] for row in rows) for key in ("stays", "exact"))
    word = _word(stays == exact)
    yield f"IPOPT's solution kept in {stays} of {exact} problems, all asked: {word}"


def _commands(rows: Sequence[Any]) -> Sheet:
    lines = []
    for people in sorted({row["people"] for row in rows}):
        some = [row for row in rows if row["people"] == people]
        count = Counter(row["verdict"] for row in some)
        same = [row for row in some if row["verdict"] == Verdict.SAME]
        lines.append(
            (
                str(people),
                str(len(some)),
                str(sum(row["near_converged"] for row in some)),
                f"{sum(row['near_oracle'] for row in same)} of {len(same)}",
                str(count[Verdict.BETTER]),
                str(count[Verdict.OTHER]),
                str(count[Verdict.UNSOLVED]),
            )
        )
    return Sheet(
        title="First command after three iterations, within "
        f"{NEAR[0]:g} m/s and {NEAR[1]:g} rad/s; IPOPT from the same warm start",
        columns=(
            "people",
            "states",
            "of our own optimum",
            "of IPOPT's, where the cost is the same",
            "IPOPT in a dearer one",
            "in a cheaper one",
            "unsolved",
        ),
        rows=tuple(lines),
    )


def _commands_notes(rows: Sequence[Any]) -> Iterator[str]:
    share = sum(row["near_converged"] for row in rows) / len(rows)
    word = _word(share >= NEAR_SHARE)
    yield f"first command that of the optimum in {share:.1%}, {NEAR_SHARE:.0%} asked: {word}"


def _failures(rows: Sequence[Any]) -> Sheet:
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    keys = ("solves", "failed", "plans", "plans_failed", "ok", "relaxed", "stop")
    return Sheet(
        title="States on which nothing may fail",
        columns=("", *(key.replace("_", " ") for key in keys)),
        rows=tuple(
            (kind, *(str(sum(row[key] for row in rows if row["kind"] == kind)) for key in keys))
            for kind in kinds
        ),
    )


def _failures_notes(rows: Sequence[Any]) -> Iterator[str]:
    failed = sum(row["failed"] + row["plans_failed"] for row in rows)
    solves = sum(row["solves"] + row["plans"] for row in rows)
    yield f"{failed} failures in {solves} solves and plans, 0 asked: {_word(not failed)}"


def _word(met: bool) -> str:
    return "met" if met else "MISSED"


_SHEETS = {
    "speed": (_speeds, _speed_notes),
    "optima": (_optima, _optima_notes),
    "commands": (_commands, _commands_notes),
    "failures": (_failures, _failures_notes),
}
