"""Claims on figures of benchmarks, and the verdicts on them.

A claim is a requirement of ours, written down before the measurements, or a statement of a
publication. Claims on rides are in ``ride_claims``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from cohelm.evaluation.report.write import Sheet

MET, MISSED, NOT_RUN = "met", "MISSED", "not run"
AGREES, PARTLY = "agrees", "agrees as far as it was run"
CONTRADICTS, UNCLEAR = "does not agree", "no clear difference"
OURS = "ss_mpc_dcbf"
ENOUGH = 20
"""Rides of a contender in a case that make a verdict a finding."""


class Bound(NamedTuple):
    """Closed range of a figure; NaN is in no range."""

    low: float = -math.inf
    high: float = math.inf

    def holds(self, value: float) -> bool:
        """Check that the value is in the range."""
        return self.low <= value <= self.high

    def text(self, *, share: bool = False) -> str:
        """``≥ 0.95``; of a share ``≥ 95 %``, ``all`` or ``none``."""
        if share and self == NONE:
            return "none"
        if share and self == ALL:
            return "all"
        if share and self == SOME:
            return "some"
        factor, unit = (100.0, " %") if share else (1.0, "")
        ends = (("≥", self.low), ("≤", self.high))
        given = [f"{sign} {factor * end:g}{unit}" for sign, end in ends if not math.isinf(end)]
        return ", ".join(given)


NONE, ALL, SOME = Bound(high=0.0), Bound(low=1.0), Bound(low=1e-9)


@dataclass(frozen=True)
class Verdict:
    """Judgement of one claim on one subject."""

    subject: str
    """Case and contender, or the source of a statement."""
    claim: str
    found: str
    required: str = ""
    result: str = ""
    """One of the words at the top of this module; empty: a figure without a bound."""
    remark: str = ""

    def __str__(self) -> str:
        required = f", required {self.required}" if self.required else ""
        remark = f"; {self.remark}" if self.remark else ""
        return f"{self.subject}: {self.claim}: {self.found}{required}: {self.result}{remark}"


def bounded(
    subject: str, claim: str, value: float, bound: Bound, found: str = "", remark: str = ""
) -> Verdict:
    """Judge a number against a bound; ``found`` replaces the number in words."""
    result = MET if bound.holds(value) else MISSED
    return Verdict(subject, claim, found or f"{value:.4g}", bound.text(), result, remark)


def verdict_sheet(verdicts: Iterable[Verdict], title: str = "Claims") -> Sheet:
    """Table of verdicts; a benchmark's last one."""
    rows = ((v.subject, v.claim, v.found, v.required, v.result, v.remark) for v in verdicts)
    return Sheet(title, ("subject", "claim", "found", "required", "verdict", "remark"), tuple(rows))


def verdict_notes(verdicts: Sequence[Verdict]) -> tuple[str, ...]:
    """Count of verdicts, and a sentence for each requirement that was missed."""
    kinds = dict.fromkeys(v.result for v in verdicts if v.result)
    counts = ", ".join(f"{sum(v.result == kind for v in verdicts)} {kind}" for kind in kinds)
    missed = (str(v) for v in verdicts if v.result == MISSED)
    return (f"claims: {counts}", *missed) if counts else ()


def verdict_summary(verdicts: Iterable[Verdict]) -> list[dict[str, str]]:
    """Verdicts for programs."""
    return [dict(vars(each)) for each in verdicts]


def measured(
    part: str,
    name: str,
    value: float,
    *,
    unit: str = "",
    bound: Bound | None = None,
    valid: bool = True,
    remark: str = "",
) -> dict[str, Any]:
    """Row of a benchmark that measures one figure per row.

    Args:
        part: of the table.
        name: of the figure.
        value: NaN misses every bound.
        unit: of the value.
        bound: required of it; None: nothing is.
        valid: False where something else that is required does not hold.
        remark: on which data, and how many.
    """
    result = "" if bound is None else MET if valid and bound.holds(float(value)) else MISSED
    return {
        "part": part,
        "figure": name,
        "value": float(value),
        "unit": unit,
        "required": "" if bound is None else bound.text(),
        "verdict": result,
        "remark": remark,
    }


def skipped(part: str, name: str, reason: str) -> dict[str, Any]:
    """Row of a figure that was not measured, with the reason."""
    return {**measured(part, name, math.nan), "verdict": NOT_RUN, "remark": reason}


def measured_sheets(rows: Sequence[Mapping[str, Any]]) -> tuple[Sheet, ...]:
    """One table per part."""

    def cells(row: Mapping[str, Any]) -> tuple[str, ...]:
        absent = row["verdict"] == NOT_RUN
        value = "" if absent else f"{row['value']:.4g} {row['unit']}".strip()
        return row["figure"], value, row["required"], row["verdict"], row["remark"]

    columns = ("", "value", "required", "verdict", "remark")
    return tuple(
        Sheet(part, columns, tuple(map(cells, each)))
        for part, each in itertools.groupby(rows, key=lambda row: str(row["part"]))
    )


def measured_notes(rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Count of verdicts, and a sentence for each figure that missed its bound or was not run."""
    counts = ", ".join(
        f"{sum(row['verdict'] == word for row in rows)} {word}" for word in (MET, MISSED, NOT_RUN)
    )
    missed = (
        f"MISSED: {row['part']}, {row['figure']}: {row['value']:.4g}, required {row['required']}"
        for row in rows
        if row["verdict"] == MISSED
    )
    absent = (
        f"not run: {row['part']}, {row['figure']}: {row['remark']}"
        for row in rows
        if row["verdict"] == NOT_RUN
    )
    return (counts, *missed, *absent)
