"""What ``cohelm people`` prints: who was there, and how well that fits the labels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from rich.table import Table

from cohelm.evaluation.labelled import WITHIN, Scores
from cohelm.evaluation.watching import LASTING, Tracks

SHOWN = 12
"""People in the table at most: those who stayed longest."""


def facts_table(tracks: Tracks) -> Table:
    """How long, how many, and how far to trust it."""
    table = _table("", "")
    sensing = ", ".join(f"{each.value} {n}" for each, n in tracks.sensing.most_common())
    table.add_row("frames", str(tracks.frames))
    table.add_row("duration", f"{tracks.end - tracks.begin:.1f} s")
    table.add_row("people told", str(len(tracks.trails)))
    table.add_row(f"longer than {LASTING:g} s", str(len(tracks.lasting())))
    table.add_row("at once, at most", str(tracks.most))
    table.add_row("groups", str(len(tracks.groups)))
    table.add_row("sensing", sensing)
    return table


def who_table(tracks: Tracks) -> Table:
    """Those who stayed longest: from when to when, and how far they walked."""
    trails = sorted(tracks.trails.items(), key=lambda each: _span(each[1]), reverse=True)
    table = _table("id", "from, s", "to, s", "moved, m", "last seen at, m")
    for who, trail in trails[:SHOWN]:
        moved = math.dist(trail[0, 1:], trail[-1, 1:])
        begin, end = trail[[0, -1], 0] - tracks.begin
        at = f"({trail[-1, 1]:.2f}, {trail[-1, 2]:.2f})"
        table.add_row(str(who), f"{begin:.1f}", f"{end:.1f}", f"{moved:.1f}", at)
    return table


def scores_table(scores: Scores) -> Table:
    """How well it fits the labels."""
    table = _table("", "")
    for name, figure in _facts(scores):
        table.add_row(name, figure)
    return table


def scores_json(scores: Scores) -> dict[str, Any]:
    """The same for programs; null where there is nothing to say."""
    who = scores.identities
    return {
        "instants": scores.instants,
        "labels": scores.labels,
        "left_out": scores.left_out,
        "within": WITHIN,
        "found": scores.found,
        "unlabelled_per_frame": scores.unlabelled,
        "unlabelled_most": scores.unlabelled_most,
        "position_error": scores.error,
        "mota": None if who is None else who.mota,
        "idf1": None if who is None else who.idf1,
        "id_changes": None if who is None else who.switches,
    }


def _facts(scores: Scores) -> list[tuple[str, str]]:
    out = [
        ("instants compared", str(scores.instants)),
        ("labels", f"{scores.labels} ({scores.left_out} more left out: too far, or hidden)"),
        (f"found within {WITHIN:g} m", _number(scores.found)),
        ("mean distance of those", f"{_number(scores.error)} m"),
        ("people without a label, mean of a frame", _number(scores.unlabelled)),
        ("the same, worst frame", str(scores.unlabelled_most)),
    ]
    who = scores.identities
    if who is None:
        return [*out, ("MOTA, IDF1, id changes", "the labels have no ids")]
    return [
        *out,
        ("MOTA", _number(who.mota)),
        ("IDF1", _number(who.idf1)),
        ("id changes", str(who.switches)),
    ]


def _number(number: float) -> str:
    return f"{number:.3f}" if math.isfinite(number) else "–"


def _span(trail: Any) -> float:
    return float(np.ptp(trail[:, 0]))


def _table(*columns: str) -> Table:
    table = Table(header_style="dim", show_header=any(columns))
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", overflow="fold")
    return table
