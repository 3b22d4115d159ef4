"""Offers of destinations: at most three, which stay in their places while they are believed.

A rider aims at a button before pressing it. So an offer keeps its slot, stays for some seconds at
least, and is replaced only by one that is believed much more.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model

SLOTS = 3
"""Largest number of offers."""
EMPTY = -1
"""Index of a slot without an offer, and of no highlighted place."""


class OfferParameters(Model):
    """Thresholds of the offers, as probabilities; chosen with ``cohelm bench destinations``."""

    show: float = Field(0.05, ge=0.0, le=1.0)
    """A place is offered from this belief on …"""
    hide: float = Field(0.02, ge=0.0, le=1.0)
    """… down to this one."""
    replace_ratio: float = Field(2.0, ge=1.0, le=100.0)
    """A place takes the slot of another if it is believed this many times as much."""
    shown_time: float = Field(3.0, ge=0.0, le=60.0)
    """Time for which an offer stays at least, s."""
    highlight: float = Field(0.9, gt=0.5, le=1.0)
    """The offer is highlighted above this belief …"""
    highlight_end: float = Field(0.75, ge=0.5, le=1.0)
    """… down to this one."""
    near: float = Field(1.5, ge=0.0, le=20.0)
    """Places closer than this are not offered: the rider is there, m."""


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class OfferState:
    """Memory of the offers."""

    slots: tuple[int, ...] = (EMPTY,) * SLOTS
    """Index of the place in each slot."""
    since: tuple[float, ...] = (0.0,) * SLOTS
    """Time at which it was put there, s."""
    highlighted: int = EMPTY
    """Index of the highlighted place."""


def update_offers(
    time: float, belief: Floats, cost: Floats, memory: OfferState | None, p: OfferParameters
) -> OfferState:
    """Choose the offers.

    Args:
        time: s.
        belief: probabilities of the n places first, (n,) or (n + 1,).
        cost: cost-to-go (n,), m.
        memory: result of the last call; None at first.
        p: thresholds.
    """
    memory = memory or OfferState()
    believed = np.where(cost >= p.near, belief[: len(cost)], 0.0)
    slots, since = list(memory.slots), list(memory.since)
    for k in range(SLOTS):
        if slots[k] != EMPTY and _ends(believed[slots[k]], time - since[k], p):
            slots[k] = EMPTY
    for place in np.argsort(-believed, kind="stable")[:SLOTS].tolist():
        slot = _slot_for(place, time, believed, slots, since, p)
        if slot is not None:
            slots[slot], since[slot] = place, time
    highlighted = _highlighted(believed, slots, memory.highlighted, p)
    chosen = OfferState(slots=tuple(slots), since=tuple(since), highlighted=highlighted)
    return memory if chosen == memory else chosen


def _ends(believed: float, shown: float, p: OfferParameters) -> bool:
    """A place that was reached ends at once; others stay for the least time."""
    return believed <= 0.0 or (believed < p.hide and shown >= p.shown_time)


def _slot_for(
    place: int,
    time: float,
    believed: Floats,
    slots: list[int],
    since: list[float],
    p: OfferParameters,
) -> int | None:
    """Slot that a place takes; None: it has one, or there is none for it."""
    if place in slots or believed[place] < p.show:
        return None
    if EMPTY in slots:
        return slots.index(EMPTY)
    weakest = min(range(SLOTS), key=lambda k: believed[slots[k]])
    # A place that is all but certain does not wait for the least time.
    free = time - since[weakest] >= p.shown_time or believed[place] > p.highlight
    return (
        weakest if free and believed[place] >= p.replace_ratio * believed[slots[weakest]] else None
    )


def _highlighted(believed: Floats, slots: list[int], before: int, p: OfferParameters) -> int:
    if before in slots and before != EMPTY and believed[before] >= p.highlight_end:
        return before
    if not len(believed):
        return EMPTY
    best = int(np.argmax(believed))
    return best if best in slots and believed[best] > p.highlight else EMPTY
