"""Values of the ride log at each tick, for simulated and live rides."""

from __future__ import annotations

import dataclasses

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.episode.ride import StopEvent
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import Crowd, GroundTruth, is_standing

ONE_STOP = 1.0
"""Shortest time between two stops, s; a shorter interval joins them."""

_NOT_A_STOP = frozenset(
    {
        Reason.OVER_LIMITS,
        Reason.TOO_CLOSE,
        Reason.ARRIVED,
        Reason.BACKING_UP,
        Reason.REVERSING,
        Reason.CREEPING,
        Reason.FLOOR_UNSEEN,
        Reason.EDGES_ALLOWED,
        Reason.POSE_DOUBTFUL,
        Reason.SCAN_PARTLY_BLIND,
        Reason.DRIVE_WEAK,
    }
)
"""Reasons of a chair that moves on, or stands as intended."""


class StopLog:
    """Stops of the chair so far, and the start of its present standstill."""

    def __init__(self) -> None:
        self.all: list[StopEvent] = []
        self._stood_since: float | None = None

    def add(self, truth: GroundTruth, tick: Tick) -> None:
        """Add one tick."""
        self.add_reason(truth.time, tick.decision.reason, tick.planning_error)
        self._add_standing(truth, tick)

    def standing(self, now: float) -> float:
        """Time since which the chair stands away from its goal, s; 0: it moves."""
        return 0.0 if self._stood_since is None else now - self._stood_since

    def add_reason(self, time: float, reason: Reason | None, detail: str = "") -> None:
        """Add the reason of a tick at ``time``, s.

        Stops less than a second apart are joined, with the reason of the first one.
        """
        if reason is None or reason in _NOT_A_STOP:
            return
        last = self.all[-1] if self.all else None
        if last is None or time - (last.time + last.duration) > ONE_STOP:
            self.all.append(StopEvent(time=time, duration=0.0, reason=reason, detail=detail))
        else:
            self.all[-1] = dataclasses.replace(last, duration=time - last.time)

    def _add_standing(self, truth: GroundTruth, tick: Tick) -> None:
        """Update the start of the standstill; standing at the goal does not count."""
        if not bool(is_standing(truth.twist)) or tick.decision.reason is Reason.ARRIVED:
            self._stood_since = None
        elif self._stood_since is None:
            self._stood_since = truth.time


def states_of(crowd: Crowd) -> Floats:
    """(x, y, v_x, v_y) of each person, (n, 4); NaN where a person is absent."""
    states = np.column_stack([crowd.position, crowd.velocity])
    return np.where(crowd.there[:, None], states, np.nan)


def row_of(tick: Tick) -> Floats:
    """(command 3, requested 3, stick 2, η) of one tick; NaN without a device."""
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
