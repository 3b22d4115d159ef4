"""``cohelm compare``: differences between two result folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cohelm.cli.report import OUTPUT, fitted_table, print_line, write_json
from cohelm.evaluation.metrics.measures import measure_info
from cohelm.evaluation.report import read_rides
from cohelm.evaluation.report.compare import MeasureChange, SweepComparison, as_dict
from cohelm.evaluation.report.compare import compare as contrasted
from cohelm.evaluation.report.ratings import ride_name
from cohelm.evaluation.report.store import part_of

_TITLE = "B − A on equal rides: mean [95 % interval], p corrected (Holm)"
REGRESSED = 1
LISTED = 10
"""Maximum number of rides listed that ended worse."""


def compare(
    before: Path, after: Path, measures: Sequence[str] | None, *, strict: bool, json: bool
) -> int:
    """Print how two sweeps differ; returns 1 where something got worse, else 0.

    Args:
        before, after: result folders, or files of rides.
        measures: to compare; None: the main ones.
        strict: one ride that ended worse counts as a regression.
        json: print JSON.

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
                print_line(f"{name.upper()} is a part: {part}")
        _print(found, worse=worse)
    return REGRESSED if worse else 0


def _print(found: SweepComparison, *, worse: bool) -> None:
    print_line(f"{found.pairs} rides in both, {found.identical} of them equal")
    for many, what in (
        (found.only_before, "only in A"),
        (found.only_after, "only in B"),
        (found.reconfigured, "with another configuration in B"),
    ):
        if many:
            print_line(f"{many} {what}")
    clear = [each for each in found.changes if each.verdict]
    if clear:
        columns = (*found.by, "measure", "A", "B", "B − A", "p", "verdict")
        styles = {"worse": "red", "better": "green"}
        OUTPUT.print(fitted_table(_TITLE, columns, [_row(each) for each in clear], styles=styles))
    for a, b in found.failures[:LISTED]:
        where = f"{ride_name(b, found.by)}, seed {b['seed']}"
        print_line(f"ended worse: {where}: {a.get('outcome')} → {b.get('outcome')}")
        if b.get("replay"):
            print_line(f"  {b['replay']}")
    if len(found.failures) > LISTED:
        print_line(f"… and {len(found.failures) - LISTED} more that ended worse")
    print_line(_verdict(found, worse=worse))


def _verdict(found: SweepComparison, *, worse: bool) -> str:
    regressions = len(found.regressions)
    if regressions:
        return f"{regressions} regression{'s' if regressions > 1 else ''}"
    if worse:
        return "rides ended worse"
    if found.identical == found.pairs:
        return "no difference"
    return "no significant regression"


def _row(each: MeasureChange) -> tuple[str, ...]:
    how, less = measure_info(each.name), each.contrast.difference
    before, after, mean, low, high = (
        how.text(x) for x in (each.before, each.after, less.mean, less.low, less.high)
    )
    p, change = f"{each.contrast.corrected:.2g}", f"{mean} [{low}, {high}]"
    return (*each.group, how.heading, before, after, change, p, each.verdict)
