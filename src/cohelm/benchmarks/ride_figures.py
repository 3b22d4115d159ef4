"""Figures of a group of rides on which claims are judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans
from cohelm.benchmarks.tables import column
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import median

SOFT = 0.2
"""Contacts up to this speed are harmless, m/s."""


class Figure(NamedTuple):
    """One number of a group of rides."""

    label: str
    value: Callable[[Rides], float]
    text: Callable[[Rides], str]
    share: bool = False
    worst: Callable[[Rides], str] | None = None
    """Command that repeats the worst ride, for the remark of a missed requirement."""


def _share(label: str, met: Callable[[Rides], Booleans], *, broken: bool = False) -> Figure:
    """Share of rides; with ``broken`` a ride ended by a program fault counts as one."""

    def value(rides: Rides) -> float:
        return float((met(rides) | rides.program_error if broken else met(rides)).mean())

    def text(rides: Rides) -> str:
        count = int(rides.program_error.sum()) if broken else 0
        ended = f", {count} ended by an error" if count else ""
        return f"{int(met(rides).sum())} of {len(rides)}{ended}"

    return Figure(label, value, text, share=True)


def _number(label: str, value: Callable[[Rides], float], unit: str) -> Figure:
    return Figure(label, value, lambda rides: f"{value(rides):.2f}{unit}")


def _fast(rides: Rides) -> Booleans:
    fast: Booleans = column(rides, "touch_speed") > SOFT
    return fast


def _standing(rides: Rides) -> Booleans:
    return rides.column("standing_contact") > 0.0


def _fastest(rides: Rides) -> str:
    speed = np.nan_to_num(column(rides, "touch_speed"))
    return f"up to {speed.max():.2f} m/s: {rides.rows[int(speed.argmax())]['replay']}"


FIGURES: Mapping[str, Figure] = {
    "reached": _share("goal reached", lambda r: r.reached),
    "collisions": _share("collisions", lambda r: r.any_collision, broken=True),
    "person_collisions": _share(
        "collisions with a person, chair moving", lambda r: r.person_collision, broken=True
    ),
    "person_contacts": _share("rides with a collision with a person", lambda r: r.person_collision),
    "standing_contacts": _share("people walked into the standing chair", _standing),
    "contacts": _share(
        "contacts, chair moving or standing", lambda r: r.any_collision | _standing(r), broken=True
    ),
    "fast_contacts": _share(f"contacts above {SOFT:g} m/s", _fast, broken=True)._replace(
        worst=_fastest
    ),
    "contact_speed": _number(
        "speed of the fastest collision with a person, m/s",
        lambda r: float(np.nan_to_num(r.column("collision_speed")).max()),
        " m/s",
    ),
    "time_ratio": _number(
        "median time ratio to empty floor", lambda r: median(r.column("time_ratio")), ""
    ),
    "gap": _number(
        "median minimum gap to a person, m", lambda r: median(r.column("min_distance")), " m"
    ),
}
