"""Tables of ``cohelm people``: facts, the people, scores against labels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.table import Table

from cohelm.arrays import Floats
from cohelm.cli.report import plain_table
from cohelm.evaluation.perception.labelled import LabelScores
from cohelm.evaluation.perception.recording_view import LASTING, RecordingSummary
from cohelm.evaluation.perception.tracking_scores import WITHIN

SHOWN = 12
"""Maximum number of people in the table: those tracked longest."""
HOLES = 3
"""Maximum number of gaps in the table."""
STEP = 0.3
"""Smallest displacement that counts as walking, m: bodies sway, and so do tracks."""


def facts_table(tracks: RecordingSummary, begin: float) -> Table:
    """Duration, counts and sensor quality; ``begin`` is the recording's, s."""
    table = plain_table("", "")
    sensing = ", ".join(f"{each.value} {n}" for each, n in tracks.sensing.most_common())
    table.add_row("frames", str(tracks.frames))
    table.add_row("duration", f"{tracks.end - tracks.begin:.1f} s")
    if tracks.gaps:
        table.add_row("no readings", _spans(tracks.gaps, begin))
    table.add_row("people tracked", str(len(tracks.trails)))
    if tracks.frames > 1:
        table.add_row(f"longer than {LASTING:g} s", str(len(tracks.lasting())))
    table.add_row("maximum at once", str(tracks.max_people))
    table.add_row("groups", str(len(tracks.groups)))
    table.add_row("sensing", sensing)
    table.add_row("sensor motion", str(tracks.ego_path))
    return table


def people_title(tracks: RecordingSummary) -> str:
    """Title of :func:`people_table`."""
    many = len(tracks.trails)
    if tracks.frames == 1:
        return "people"
    return "people tracked longest" + (f", {SHOWN} of {many}" if many > SHOWN else "")


def people_table(tracks: RecordingSummary, begin: float) -> Table:
    """People tracked longest: from and to since ``begin``, s, and the distance walked."""
    trails = sorted(tracks.trails.items(), key=lambda each: _span(each[1]), reverse=True)
    if tracks.frames == 1:
        return _places(trails)
    table = plain_table("id", "from, s", "to, s", "walked, m", "last position, m")
    for who, trail in trails[:SHOWN]:
        first, last = trail[[0, -1], 0] - begin
        times = f"{first:.1f}", f"{last:.1f}"
        table.add_row(str(who), *times, f"{walked(trail):.1f}", _place(trail))
    return table


def scores_table(scores: LabelScores) -> Table:
    """Table of the scores against the labels."""
    table = plain_table("", "")
    for name, figure in _facts(scores):
        table.add_row(name, figure)
    return table


def scores_json(scores: LabelScores) -> dict[str, Any]:
    """Scores as JSON; null where a score is not defined."""
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


def _facts(scores: LabelScores) -> list[tuple[str, str]]:
    out = [
        ("instants compared", str(scores.instants)),
        ("labels", f"{scores.labels} ({scores.left_out} more ignored: too far, or hidden)"),
        (f"found within {WITHIN:g} m", _number(scores.found)),
        ("mean distance of found", f"{_number(scores.error)} m"),
        ("unlabelled people per frame, mean", _number(scores.unlabelled)),
        ("unlabelled people per frame, maximum", str(scores.unlabelled_most)),
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
    """Distance along a trail (k, 3) of (time s, x, y m), in steps of ``STEP`` or more."""
    total, (x, y) = 0.0, trail[0, 1:]
    for u, v in trail[1:, 1:].tolist():
        step = math.hypot(u - x, v - y)
        if step >= STEP:
            total, x, y = total + step, u, v
    return total


def _places(trails: Sequence[tuple[int, Floats]]) -> Table:
    """Positions only: a single frame has no durations."""
    table = plain_table("id", "at, m")
    for who, trail in trails:
        table.add_row(str(who), _place(trail))
    return table


def _place(trail: Floats) -> str:
    return f"({trail[-1, 1]:.2f}, {trail[-1, 2]:.2f})"


def _spans(spans: Sequence[tuple[float, float]], begin: float) -> str:
    """The first of the spans, s, in words."""
    said = [f"{first - begin:.1f} to {last - begin:.1f} s" for first, last in spans[:HOLES]]
    more = len(spans) - len(said)
    return ", ".join(said) + (f", and {more} more" if more else "")


def _span(trail: Any) -> float:
    return float(np.ptp(trail[:, 0]))
