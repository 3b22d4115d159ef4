"""Faults of the detection of people: ghosts, lost people, swapped ids."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Booleans, Floats, replace
from cohelm.messages import Observation, Scan
from cohelm.simulation.faults.api import POSITIVE, SHARE, FaultInput, FaultKind
from cohelm.simulation.faults.scan_values import bearings, each_scan

GHOST_RADIUS = 0.15
"""m."""
_SWAP_TIME = 0.5
"""Time between two exchanges of ids, s."""


def _ghost(o: Observation, at: FaultInput) -> Observation:
    """Show a body at a distance ahead that moves along with the chair."""

    def ranges(scan: Scan) -> Floats:
        half = np.arcsin(min(GHOST_RADIUS / at.size, 1.0))
        ahead = np.abs(bearings(scan)) <= half
        near = at.size + 0.01 * at.rng.standard_normal(len(scan.ranges))
        return np.where(ahead, np.fmin(near, scan.ranges), scan.ranges)

    return each_scan(o, lambda scan: replace(scan, ranges=ranges(scan)))


def _swapped(o: Observation, _: FaultInput) -> Observation:
    """Exchange the ids of given people every half second."""
    if o.people is None or len(o.people.id) < 2:
        return o
    by = int(o.time / _SWAP_TIME) % len(o.people.id)
    return replace(o, people=replace(o.people, id=np.roll(o.people.id, by)))


def unseen_people(n: int, share: float, pattern: np.random.Generator) -> Booleans:
    """Mask (n,) of the people whom no sensor sees."""
    return np.asarray(pattern.permutation(n) < round(share * n))


PEOPLE: Mapping[str, FaultKind] = MappingProxyType(
    {
        "people_ghost": FaultKind(
            text="ghost ahead that moves along",
            effect=_ghost,
            unit="m",
            typical=2.0,
            bounds=(0.2, 20.0),
            intensities=(1.0, 3.0),
        ),
        "people_lost": FaultKind(
            text="people whom no sensor sees",
            unit="share",
            bounds=SHARE,
            intensities=(0.5, 1.0),
        ),
        "people_swapped": FaultKind(
            text="ids of people exchanged (tracker given)", effect=_swapped, bounds=POSITIVE
        ),
    }
)
