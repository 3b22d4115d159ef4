"""Rides of riders in modes, picked and paired."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.results.rides import Rides, Row

BY = ("scene", "rider", "mode")
"""What tells the rides of one seed apart."""


def touch_speed(rides: Rides) -> Floats:
    """The chair's speed at its fastest touch, of a person or a thing, (k,), m/s; NaN: none."""
    return np.fmax(rides.column("collision_speed"), rides.column("collision_speed_wall"))


def in_order(rows: Sequence[Row], key: str) -> list[Any]:
    """What there is of a column, each once, as it comes."""
    return list(dict.fromkeys(row[key] for row in rows))


def differences(one: Rides, other: Rides, key: str) -> Floats:
    """One's measure less the other's, (c,): a mean over the riders for each scene and seed.

    The riders of one scene and seed meet the same people, and ``autonomous`` rides the same ride
    with each: they are no independent rides, so that they count as one. NaN: no rider has both.
    """
    found: dict[tuple[str, int], list[float]] = {}
    for at, less in zip(one.pairs(other)[0], one.less(other, key), strict=True):
        row = one.rows[at]
        found.setdefault((row["scene"], row["seed"]), []).append(float(less))
    return np.array([_mean(each) for each in found.values()])


def _mean(values: list[float]) -> float:
    there = [each for each in values if np.isfinite(each)]
    return float(np.mean(there)) if there else float("nan")
