"""Findings of the health monitor and the safety gate in rides; without a fault, false alarms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from scipy import stats

from cohelm.evaluation.episode.ride import Ride
from cohelm.messages import Reason
from cohelm.navigation import Tick
from cohelm.simulation import GroundTruth

INPUT_REASONS = frozenset(
    {
        *(Reason.NOT_FINITE, Reason.CLOCK, Reason.STALE_SCAN, Reason.STALE_POSE),
        *(Reason.STALE_TWIST, Reason.POSE_JUMP, Reason.STALE_RIDER_COMMAND, Reason.LATE),
    }
)
"""Reasons of the safety gate that detect a fault of the input."""


class Alarm(NamedTuple):
    """Beginning of a finding."""

    time: float
    """s."""
    reason: str


class AlarmWatch:
    """Collects the alarms of a ride: one per uninterrupted time with a finding."""

    def __init__(self) -> None:
        self.alarms: list[Alarm] = []
        self._lasts = False

    def see(self, tick: Tick, truth: GroundTruth) -> list[str]:
        """Reasons found in a tick."""
        reasons = [each.reason.value for each in tick.health.findings]
        if tick.decision.reason in INPUT_REASONS:
            reasons.append(str(tick.decision.reason))
        if reasons and not self._lasts:
            self.alarms.append(Alarm(truth.time, reasons[0]))
        self._lasts = bool(reasons)
        return reasons

    def columns(self, ride: Ride) -> Mapping[str, Any]:
        """Columns of a ride: its duration, s, the number of alarms, and what they were."""
        return {
            "duration": float(ride.time[-1]),
            "alarms": len(self.alarms),
            "alarm_reasons": ", ".join(
                f"{each.reason} at {each.time:.1f} s" for each in self.alarms
            ),
        }


def alarm_note(sound: Sequence[Mapping[str, Any]]) -> str:
    """Sentence on false alarms per hour of faultless rides, with its exact Poisson interval."""
    hours = sum(float(row["duration"]) for row in sound) / 3600.0
    alarms = int(sum(float(row["alarms"]) for row in sound))
    if not hours:
        return "no rides without a fault"
    low = stats.chi2.ppf(0.025, 2 * alarms) / 2.0 if alarms else 0.0
    high = stats.chi2.ppf(0.975, 2 * alarms + 2) / 2.0
    return (
        f"false alarms: {alarms} in {hours:.2f} h without a fault, "
        f"{alarms / hours:.1f} an hour [{low / hours:.1f}, {high / hours:.1f}]"
    )
