"""``cohelm compare``: two result folders, and what got worse from one to the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from cohelm.cli.report import OUTPUT, write_json
from cohelm.evaluation.results import read_rides
from cohelm.evaluation.results.compare import Change, Comparison, as_dict
from cohelm.evaluation.results.compare import compare as contrasted
from cohelm.evaluation.results.measures import measure
from cohelm.evaluation.results.ratings import name_of
from cohelm.evaluation.results.store import part_of

REGRESSED = 1
LISTED = 10
"""Rides that ended worse that are named one by one."""


def compare(
    before: Path, after: Path, measures: Sequence[str] | None, *, strict: bool, json: bool
) -> int:
    """Say how two sweeps differ; returns 1 where something got worse, else 0.

    Args:
        before, after: result folders, or files of rides.
        measures: to judge; None: the usual ones.
        strict: one ride that ended worse is enough.
        json: for programs.

    Raises:
        ConfigError: if a folder holds no rides, or both have none in common.
    """
    both = read_rides(before), read_rides(after)
    parts = {
        name: part_of(len(rides), folder)
        for name, rides, folder in zip("ab", both, (before, after), strict=True)
    }
    found = contrasted(*both, measures)
    worse = bool(found.regressions) or (strict and bool(found.failures))
    if json:
        said = {"a": str(before), "b": str(after), "parts": parts, "regressed": worse}
        write_json({**as_dict(found), **said})
    else:
        for name, part in parts.items():
            if part:
                _line(f"{name.upper()} is a part: {part}")
        _say(found, worse=worse)
    return REGRESSED if worse else 0


def _say(found: Comparison, *, worse: bool) -> None:
    _line(f"{found.pairs} rides in both, {found.identical} of them equal in all that is judged")
    for many, what in (
        (found.only_before, "only in A"),
        (found.only_after, "only in B"),
        (found.reconfigured, "with another configuration in B"),
    ):
        if many:
            _line(f"{many} {what}")
    clear = [each for each in found.changes if each.verdict]
    if clear:
        OUTPUT.print(_table(found.by, clear))
    for a, b in found.failures[:LISTED]:
        where = f"{name_of(b, found.by)}, seed {b['seed']}"
        _line(f"ended worse: {where}: {a.get('outcome')} → {b.get('outcome')}")
        if b.get("replay"):
            _line(f"  {b['replay']}")
    if len(found.failures) > LISTED:
        _line(f"… and {len(found.failures) - LISTED} others that ended worse")
    _line(_verdict(found, worse=worse))


def _verdict(found: Comparison, *, worse: bool) -> str:
    regressions = len(found.regressions)
    if regressions:
        return f"{regressions} regression{'s' if regressions > 1 else ''}"
    if worse:
        return "rides ended worse"
    if found.identical == found.pairs:
        return "no difference"
    return "no regression that is more than chance"


def _table(by: Sequence[str], changes: Sequence[Change]) -> Table:
    table = Table(
        title=Text("B less A on equal rides: mean [95 % interval], p corrected (Holm)"),
        title_justify="left", header_style="dim",
    )  # fmt: skip
    for name in (*by, "measure"):
        table.add_column(Text(name), overflow="fold")
    for name in ("A", "B", "less", "p", ""):
        table.add_column(name, justify="right")
    for each in changes:
        how, less = measure(each.name), each.less.less
        factor = 100.0 if how.share else 1.0
        digits = max(how.digits, 1) if how.share else how.digits
        before, after, mean, low, high = (
            "–" if math.isnan(x) else f"{factor * x:.{digits}f}"
            for x in (each.before, each.after, less.mean, less.low, less.high)
        )
        style = {"worse": "red", "better": "green"}.get(each.verdict, "")
        table.add_row(
            *(Text(part) for part in each.group), how.label, before, after,
            f"{mean} [{low}, {high}]", f"{each.less.corrected:.2g}", Text(each.verdict, style),
        )  # fmt: skip
    return table


def _line(text: str) -> None:
    OUTPUT.print(text, markup=False, soft_wrap=True)
