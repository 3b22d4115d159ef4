"""One ride of a drive: from the first movement until the chair arrives, touches or is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

from cohelm.driving.messages import Device, Ended, Goal, Limits
from cohelm.driving.records import InForceAt, Outcome, RideLog, RideRecord
from cohelm.messages import Mode

_K = TypeVar("_K")


@dataclass(frozen=True, slots=True, kw_only=True)
class Trip:
    """What is known of a ride that goes on."""

    ride: str
    """Its id."""
    session: str
    began: str
    """ISO 8601, UTC."""
    seed: int
    time: float = 0.0
    """s."""
    length: float = 0.0
    """m."""
    goal: Goal | None = None
    """Where it goes; None: wherever the rider steers."""
    wishes: int = 0
    modes: Mapping[Mode, float] = field(default_factory=dict)
    devices: Mapping[str, float] = field(default_factory=dict)
    limits: tuple[InForceAt, ...] = ()

    def on(
        self, dt: float, way: float, mode: Mode, device: Device, limits: Limits, wishes: int
    ) -> Trip:
        """A step later.

        Args:
            dt: its length, s.
            way: how far the chair came in it, m.
            mode, device, limits, wishes: those of the step.
        """
        changed = not self.limits or self.limits[-1].limits != limits
        steered = self.devices if device == "none" else _longer(self.devices, device, dt)
        return replace(
            self,
            time=self.time + dt,
            length=self.length + way,
            wishes=wishes,
            modes=_longer(self.modes, mode, dt),
            devices=steered,
            limits=(*self.limits, InForceAt(time=self.time, limits=limits))
            if changed
            else self.limits,
        )

    def ended(self, outcome: Outcome) -> Ended:
        """What a page is told of its end."""
        return Ended(
            ride=self.ride,
            outcome=outcome,
            time=round(self.time, 2),
            length=round(self.length, 2),
        )

    def record(self, outcome: Outcome, log: RideLog | None) -> RideRecord:
        """What is kept of it.

        Args:
            outcome: how it ended.
            log: of the navigator's process; None: that was lost.
        """
        return RideRecord(
            id=self.ride,
            session=self.session,
            began=self.began,
            seed=self.seed,
            destination=_named(self.goal),
            outcome=outcome,
            time=round(self.time, 2),
            length=round(self.length, 2),
            modes=self.modes,
            devices=self.devices,
            wishes=self.wishes,
            limits=self.limits,
            stops=log.stops if log is not None else (),
        )


def _named(goal: Goal | None) -> str:
    if goal is None:
        return ""
    return goal.name or f"({goal.x:.1f}, {goal.y:.1f})"


def _longer(durations: Mapping[_K, float], key: _K, dt: float) -> dict[_K, float]:
    return {**durations, key: round(durations.get(key, 0.0) + dt, 6)}
