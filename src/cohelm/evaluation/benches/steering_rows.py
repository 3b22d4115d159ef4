"""Rides of riders in modes, picked and paired."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.rides_report import Group, Row

_WHOLE_RIDES = ("time", "path_length", "heading_change")


class Rides(Group):
    """Rides of any riders, modes and scenes together, by seed."""

    def column(self, key: str) -> Floats:
        """(k,), NaN where a ride has none; ``touched`` as 0 or 1.

        Time, length and turning are those of rides that arrived.
        """
        if key == "touched":
            return self.touched.astype(float)
        values = super().column(key)
        return np.where(self.reached, values, np.nan) if key in _WHOLE_RIDES else values

    @property
    def touch_speed(self) -> Floats:
        """The chair's speed at its fastest touch, of a person or a thing, (k,), m/s; NaN: none."""
        person, wall = (
            super(Rides, self).column(key) for key in ("collision_speed", "collision_speed_wall")
        )
        return np.fmax(person, wall)

    def only(self, **what: Any) -> Rides:
        """Those whose columns are as given: ``only(mode="shared")``."""
        return Rides([r for r in self.rows if all(r[key] == each for key, each in what.items())])


def in_order(rows: Sequence[Row], key: str) -> list[Any]:
    """What there is of a column, each once, as it comes."""
    return list(dict.fromkeys(row[key] for row in rows))


def differences(one: Rides, other: Rides, key: str) -> Floats:
    """One's measure less the other's, (c,): a mean over the riders for each scene and seed.

    The riders of one scene and seed meet the same people, and ``autonomous`` rides the same ride
    with each: they are no independent rides, so that they count as one. NaN: no rider has both.
    """
    theirs = dict(zip(map(_ride_of, other.rows), other.column(key), strict=True))
    found: dict[tuple[str, int], list[float]] = {}
    for row, value in zip(one.rows, one.column(key), strict=True):
        if _ride_of(row) in theirs:
            less = float(value - theirs[_ride_of(row)])
            found.setdefault((row["scene"], row["seed"]), []).append(less)
    return np.array([_mean(each) for each in found.values()])


def _ride_of(row: Row) -> tuple[str, str, int]:
    return row["scene"], row["rider"], int(row["seed"])


def _mean(values: list[float]) -> float:
    there = [each for each in values if np.isfinite(each)]
    return float(np.mean(there)) if there else float("nan")
