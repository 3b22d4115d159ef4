"""What ``cohelm people`` prints: who was there, and how well that fits the labels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from cohelm.arrays import Floats
from cohelm.evaluation.labelled import Scores
from cohelm.evaluation.perceived_scores import WITHIN
from cohelm.evaluation.watching import LASTING, Tracks

SHOWN = 12
"""People in the table at most: those who stayed longest."""
HOLES = 3
"""Times without readings in the table at most."""
STEP = 0.3
"""Least that somebody moves before it counts as walking, m: a body sways, and so does a track."""


def facts_table(tracks: Tracks, begin: float) -> Table:
    """How long, how many, and how far to trust it; ``begin`` is the recording's, s."""
    table = _table("", "")
    sensing = ", ".join(f"{each.value} {n}" for each, n in tracks.sensing.most_common())
    table.add_row("frames", str(tracks.frames))
    table.add_row("duration", f"{tracks.end - tracks.begin:.1f} s")
    if tracks.holes:
        table.add_row("no readings", _spans(tracks.holes, begin))
    table.add_row("people told", str(len(tracks.trails)))
    if tracks.frames > 1:
        table.add_row(f"longer than {LASTING:g} s", str(len(tracks.lasting())))
    table.add_row("at once, at most", str(tracks.most))
    table.add_row("groups", str(len(tracks.groups)))
    table.add_row("sensing", sensing)
    table.add_row("the sensor's way", str(tracks.way))
    return table


def who_title(tracks: Tracks) -> str:
    """What :func:`who_table` shows."""
    many = len(tracks.trails)
    if tracks.frames == 1:
        return "who is there"
    return "who stayed longest" + (f", {SHOWN} of {many}" if many > SHOWN else "")


def who_table(tracks: Tracks, begin: float) -> Table:
    """Those who stayed longest: from when to when since ``begin``, s, and how far they walked."""
    trails = sorted(tracks.trails.items(), key=lambda each: _span(each[1]), reverse=True)
    if tracks.frames == 1:
        return _places(trails)
    table = _table("id", "from, s", "to, s", "walked, m", "last seen at, m")
    for who, trail in trails[:SHOWN]:
        first, last = trail[[0, -1], 0] - begin
        times = f"{first:.1f}", f"{last:.1f}"
        table.add_row(str(who), *times, f"{walked(trail):.1f}", _place(trail))
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


def walked(trail: Floats) -> float:
    """Length of the way along a trail (k, 3) of (time s, x, y m), by steps of ``STEP`` or more."""
    total, (x, y) = 0.0, trail[0, 1:]
    for u, v in trail[1:, 1:].tolist():
        step = math.hypot(u - x, v - y)
        if step >= STEP:
            total, x, y = total + step, u, v
    return total


def _places(trails: Sequence[tuple[int, Floats]]) -> Table:
    """Of a still picture there is nothing else to say."""
    table = _table("id", "at, m")
    for who, trail in trails:
        table.add_row(str(who), _place(trail))
    return table


def _place(trail: Floats) -> str:
    return f"({trail[-1, 1]:.2f}, {trail[-1, 2]:.2f})"


def _spans(spans: Sequence[tuple[float, float]], begin: float) -> str:
    """Some of the spans, s."""
    said = [f"{first - begin:.1f} to {last - begin:.1f} s" for first, last in spans[:HOLES]]
    more = len(spans) - len(said)
    return ", ".join(said) + (f", and {more} times more" if more else "")


def _span(trail: Any) -> float:
    return float(np.ptp(trail[:, 0]))


def _table(*columns: str) -> Table:
    table = Table(header_style="dim", show_header=any(columns))
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", overflow="fold")
    return table
