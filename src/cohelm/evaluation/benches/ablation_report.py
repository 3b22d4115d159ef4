"""What ``cohelm bench ablation`` says: differences on the same seeds, together and by scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.bench import Report, Sheet
from cohelm.evaluation.benches.rides_report import (
    faults,
    groups_of,
    picture,
    scene_sheet,
    signed,
    sources,
)
from cohelm.evaluation.benches.rides_verdicts import ENOUGH, few
from cohelm.evaluation.bootstrap import Estimate, mean_of
from cohelm.evaluation.results.rides import Rides, Row


class Shown(NamedTuple):
    """How a measure is shown."""

    head: str
    better: int
    """The sign of what is better."""
    factor: float = 1.0
    digits: int = 2


SHOWN = {
    "reached": Shown("reached, %", 1, 100.0, 1),
    "hit_moving": Shown("hit moving, %", -1, 100.0, 1),
    "time": Shown("time, s", -1),
    "min_distance": Shown("gap, m", 1),
    "proxemics_intimate": Shown("below 0.45 m, %", -1, 100.0, 1),
}
"""The measures that are compared."""
ALL = "all scenes"

Less = dict[str, dict[str, Estimate]]
"""Variant → measure → how much more there is of it without the idea."""


def make_report(
    rows: Sequence[Row], bases: Mapping[str, str], says: Mapping[str, str], folder: Path
) -> Report:
    """Tables, sentences, a summary and the picture.

    Args:
        rows: as ``ride_row`` gives them, the variants in place of planners.
        bases: variant → what it is compared with; itself where it is such a base.
        says: variant → what is done instead.
        folder: for the picture.
    """
    groups = groups_of(rows)
    less = {ALL: _together(groups, bases)}
    less |= {scene: _less(each, bases) for scene, each in groups.items()}
    sheets = [_sheet(where, each) for where, each in less.items()]
    sheets += [scene_sheet(scene, each) for scene, each in groups.items()]
    return Report(
        sheets=tuple(sheets),
        notes=(*sources(rows), *faults(rows), *_sentences(less[ALL], says)),
        summary={
            "differences": {
                where: {
                    name: {key: _as_dict(each) for key, each in by_key.items()}
                    for name, by_key in by_name.items()
                }
                for where, by_name in less.items()
            },
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
        files=(picture(groups, folder / "ablation.png"),),
    )


def _less(by_variant: Mapping[str, Rides], bases: Mapping[str, str]) -> Less:
    return {
        name: {key: mean_of(each) for key, each in values.items()}
        for name, values in _values(by_variant, bases).items()
    }


def _together(groups: Mapping[str, Mapping[str, Rides]], bases: Mapping[str, str]) -> Less:
    """Over the rides of all scenes."""
    found: dict[str, dict[str, list[Floats]]] = {}
    for by_variant in groups.values():
        for name, values in _values(by_variant, bases).items():
            for key, each in values.items():
                found.setdefault(name, {}).setdefault(key, []).append(each)
    return {
        name: {key: mean_of(np.concatenate(each)) for key, each in values.items()}
        for name, values in found.items()
    }


def _values(
    by_variant: Mapping[str, Rides], bases: Mapping[str, str]
) -> dict[str, dict[str, Floats]]:
    """Variant → measure → its value less that of what it is compared with, by ride."""
    out = {}
    for name, group in by_variant.items():
        base = bases.get(name, name)
        if base != name and base in by_variant:
            out[name] = {key: group.less(by_variant[base], key) for key in SHOWN}
    return out


def _sheet(where: str, less: Less) -> Sheet:
    return Sheet(
        title=f"{where}: without it, less with it (mean [95 % interval])",
        columns=("left out", *(each.head for each in SHOWN.values())),
        rows=tuple(
            (name, *(signed(by_key[key], how.factor, how.digits) for key, how in SHOWN.items()))
            for name, by_key in less.items()
        ),
    )


def _sentences(less: Less, says: Mapping[str, str]) -> list[str]:
    """Of each variant, what clearly gets better or worse without the idea."""
    out = []
    for name, by_key in less.items():
        worse: list[str] = []
        better: list[str] = []
        for key, each in by_key.items():
            if each.count < ENOUGH or each.low <= 0.0 <= each.high:
                continue
            how = SHOWN[key]
            text = f"{how.head} {how.factor * each.mean:+.{how.digits}f}"
            (better if each.mean * how.better > 0.0 else worse).append(text)
        found = "; ".join(
            f"clearly {word}: {', '.join(what)}"
            for word, what in (("worse", worse), ("better", better))
            if what
        )
        rides = max((each.count for each in by_key.values()), default=0)
        nothing = few(rides) if rides < ENOUGH else "no clear difference"
        out.append(f"{name} ({says.get(name, '')}): {found or nothing}")
    return out


def _as_dict(each: Estimate) -> dict[str, Any]:
    return {"mean": each.mean, "low": each.low, "high": each.high, "count": each.count}
