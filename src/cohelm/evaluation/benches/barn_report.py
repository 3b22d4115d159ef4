"""What ``cohelm bench barn`` says: a row for each planner, success by difficulty, a gallery."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.evaluation.barn import BarnOutcome, BarnWorlds
from cohelm.evaluation.benches.barn_pictures import draw_difficulty, draw_gallery
from cohelm.evaluation.benches.bench import Report, Result, Sheet
from cohelm.evaluation.benches.rides_verdicts import ENOUGH, few
from cohelm.evaluation.bootstrap import share

CLASSES = 5
"""Of difficulty."""
ASKED = {"ss_mpc_dcbf": 0.95, "dwa": 0.8}
"""The least share of successes over all worlds."""

_MEANS = ("score", "score_until_2026", "mean_speed", "least_gap", "replans", "held_time")


def make_report(results: Sequence[Result], worlds: BarnWorlds, folder: Path) -> Report:
    """Tables, sentences, a summary and the pictures."""
    by_planner: dict[str, list[Result]] = {}
    for each in results:
        by_planner.setdefault(each.row["planner"], []).append(each)
    rows = {planner: [r.row for r in each] for planner, each in by_planner.items()}
    figures = {planner: _figures(each) for planner, each in rows.items()}
    hardness = difficulty(worlds)
    bounds = np.quantile(hardness, np.linspace(0.0, 1.0, CLASSES + 1)[1:-1])
    kind = np.digitize(hardness, bounds).astype(np.int64)
    classes = {planner: _by_class(each, kind) for planner, each in rows.items()}
    notes = [
        "a 2-D port of the worlds: not to be compared with figures from Gazebo, nor the score with "
        "the one that was used until March 2026",
        *_verdicts(rows),
    ]
    files = (
        draw_difficulty(classes, folder / "difficulty.png"),
        draw_gallery(by_planner, worlds, hardness, folder / "gallery.png"),
    )
    return Report(
        sheets=(_table(figures), _class_table(classes)),
        notes=tuple(notes),
        summary={"planners": figures, "success_by_difficulty": classes, "source": worlds.source},
        files=files,
    )


def difficulty(worlds: BarnWorlds) -> Floats:
    """How much longer than straight each world's reference path is, (n,).

    The benchmark's own measure (a mean of five metrics along the path) is not in the data.
    """
    straight = float(np.hypot(*(worlds.goal - worlds.start[:2])))
    longer: Floats = worlds.length / straight
    return longer


def _figures(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Shares and means over a planner's rides; the time is that of the successes."""
    outcomes = np.array([row["outcome"] for row in rows])
    won = outcomes == BarnOutcome.SUCCESS.value
    took = np.array([row["time"] for row in rows])
    means = {key: float(np.mean([row[key] for row in rows])) for key in _MEANS}
    return {
        "rides": float(len(rows)),
        **{each.value: float(np.mean(outcomes == each.value)) for each in BarnOutcome},
        "time": float(took[won].mean()) if won.any() else float("nan"),
        **means,
        "tick_ms": float(np.median([row["tick_ms"] for row in rows])),
        "control_ms": float(np.median([row["control_ms"] for row in rows])),
        "control_p99_ms": float(np.max([row["control_p99_ms"] for row in rows])),
    }


def _table(figures: Mapping[str, Mapping[str, float]]) -> Sheet:
    columns = {
        "rides": ("rides", "{:.0f}"),
        "success": ("success", "{:.3f}"),
        "collision": ("collision", "{:.3f}"),
        "timeout": ("timeout", "{:.3f}"),
        "time": ("time of successes, s", "{:.2f}"),
        "score": ("score", "{:.3f}"),
        "score_until_2026": ("score, rule until March 2026", "{:.3f}"),
        "least_gap": ("least gap, m", "{:.3f}"),
        "replans": ("new paths", "{:.1f}"),
        "control_ms": ("plan, median ms", "{:.1f}"),
        "tick_ms": ("tick, median ms", "{:.1f}"),
    }
    return Sheet(
        title="BARN worlds, 2-D port; means over the worlds; at best 0.5 and 0.25",
        columns=("planner", *(title for title, _ in columns.values())),
        rows=tuple(
            (planner, *(form.format(each[key]) for key, (_, form) in columns.items()))
            for planner, each in figures.items()
        ),
    )


def _by_class(rows: Sequence[Mapping[str, Any]], kind: Integers) -> list[float]:
    """Share of successes in each class of difficulty; NaN where nothing was ridden.

    kind: (n,) class of each world.
    """
    won = np.array([row["outcome"] == BarnOutcome.SUCCESS.value for row in rows])
    of = np.array([kind[row["world"]] for row in rows])
    return [float(won[of == k].mean()) if (of == k).any() else float("nan") for k in range(CLASSES)]


def _class_table(classes: Mapping[str, Sequence[float]]) -> Sheet:
    return Sheet(
        title="success by how much longer than straight the reference path is, in fifths",
        columns=("planner", "straightest", *(f"{k}." for k in range(2, CLASSES)), "most winding"),
        rows=tuple(
            (name, *("–" if math.isnan(v) else f"{v:.3f}" for v in each))
            for name, each in classes.items()
        ),
    )


def _verdicts(rows: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    out = []
    for planner, least in ASKED.items():
        each = rows.get(planner, ())
        if each:
            won = share(np.array([r["outcome"] == BarnOutcome.SUCCESS.value for r in each]))
            word = "met" if won.mean >= least else "MISSED"
            if len(each) < ENOUGH:
                word = f"{word}, but {few(len(each))}"
            out.append(
                f"{planner}: success {won.mean:.3f} ({won.low:.3f} to {won.high:.3f}) in "
                f"{len(each)} rides, asked for {least:g}: {word}"
            )
    return out
