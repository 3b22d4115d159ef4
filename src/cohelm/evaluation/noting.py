"""What a ride's log notes at each tick, whoever keeps it."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.ride import Stop
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import Crowd, Truth, is_standing

ONE_STOP = 1.0
"""Between the end of a stop and the beginning of another, s; less is the same stop."""

_NOT_A_STOP = frozenset(
    {
        Reason.OVER_LIMITS,
        Reason.TOO_CLOSE,
        Reason.ARRIVED,
        Reason.BACKING_UP,
        Reason.CREEPING,
    }
)
"""Reasons with which the chair goes on, or rightly stands: no stop is noted."""


class Stops:
    """When the chair stood or braked and said why, and since when it stands."""

    def __init__(self) -> None:
        self.all: list[Stop] = []
        self._stood_since: float | None = None

    def add(self, truth: Truth, tick: Tick) -> None:
        """One tick more."""
        self._note_stop(truth, tick)
        self._note_standing(truth, tick)

    def standing(self, now: float) -> float:
        """For how long the chair has stood elsewhere than at its goal, s; 0: it moves."""
        return 0.0 if self._stood_since is None else now - self._stood_since

    def _note_stop(self, truth: Truth, tick: Tick) -> None:
        """Two stops less than a second apart are one, with the first's reason."""
        reason = tick.decision.reason
        if reason is None or reason in _NOT_A_STOP:
            return
        last = self.all[-1] if self.all else None
        if last is None or truth.time - (last.time + last.duration) > ONE_STOP:
            begun = Stop(time=truth.time, duration=0.0, reason=reason, detail=tick.trouble)
            self.all.append(begun)
        else:
            self.all[-1] = dataclasses.replace(last, duration=truth.time - last.time)

    def _note_standing(self, truth: Truth, tick: Tick) -> None:
        """Since when the chair stands; at its goal it may."""
        if not bool(is_standing(truth.twist)) or tick.decision.reason is Reason.ARRIVED:
            self._stood_since = None
        elif self._stood_since is None:
            self._stood_since = truth.time


def states_of(crowd: Crowd) -> Floats:
    """(x, y, v_x, v_y) of each, (n, 4); NaN for who is not there."""
    states = np.column_stack([crowd.position, crowd.velocity])
    return np.where(crowd.there[:, None], states, np.nan)


def row_of(tick: Tick) -> Floats:
    """(command 3, asked 3, stick 2, η) of one tick; NaN where there is no device."""
    authority, rider = tick.authority, tick.observation.rider
    there = authority is not None and rider is not None
    return np.concatenate(
        [
            tick.decision.twist,
            authority.twist if authority is not None and there else np.full(3, np.nan),
            rider.deflection if rider is not None else np.full(2, np.nan),
            [authority.eta if authority is not None else 0.0],
        ]
    )
