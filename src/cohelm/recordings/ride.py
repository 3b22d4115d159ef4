"""What a recorded ride is: what the navigator was made of, and every tick that it lived through."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from cohelm.arrays import value
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, Decision, Observation, Request
from cohelm.navigation import Tick
from cohelm.robots import Robot

FORMAT = 1
"""Grows when a recording can no longer be read as before."""
RIDE_TOPIC = "/cohelm/ride"
"""A :class:`RideFacts`, packed by :mod:`.exact`; the first message."""
TICK_TOPIC = "/cohelm/tick"
"""A :class:`RideTick` each, packed by :mod:`.exact`."""


@value
class RideFacts:
    """All that must be known to set up the same navigator again; no file beside is needed."""

    format: int = FORMAT
    name: str
    """Of the scenario."""
    seed: int
    versions: Mapping[str, str]
    """Of cohelm and of what decides the numbers, by name; ``code`` is a digest of cohelm's own."""
    scenario: Mapping[str, Any]
    """The whole scenario, as its YAML would say it."""
    robot: Robot
    grid: OccupancyGrid
    """The map as the navigator had it."""
    filters: tuple[CostmapFilter, ...] = ()
    heat: Crowding | None = None


@value
class RideTick:
    """What went into the navigator at one tick, and what it decided."""

    number: int
    """Of the tick, from 0 on, without a gap."""
    observation: Observation
    request: Request | None = None
    """None: that of the tick before."""
    decision: Decision
    made: str
    """See :func:`made_of`."""


def made_of(tick: Tick) -> str:
    """A digest of what led to a decision: people, futures, route, references, η and the plan.

    Two equal commands may come of different things seen; two equal digests hardly do.
    """
    people, plan, futures = tick.people, tick.plan, tick.predictions
    arrays = [people.id, people.mean, people.covariance, people.heading]
    if futures is not None:
        arrays += [futures.weight, futures.mean]
    if tick.path is not None:
        arrays.append(tick.path.points)
    arrays += [each.poses for each in (tick.reference, tick.shared, plan) if each is not None]
    if plan is not None:
        arrays += [plan.inputs, plan.command]
    if tick.authority is not None:
        arrays += [np.array(tick.authority.eta), tick.authority.twist]
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()
