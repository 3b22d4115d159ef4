"""Fault of one part of a chair: its kind, onset, duration and magnitude."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from cohelm.config import Model, nearest

_ROUNDING = 1e-9


class Fault(Model):
    """One fault, active from ``at`` for ``duration``."""

    kind: str
    """Name in ``FAULT_KINDS``: ``scan_…`` of planar scanners, ``pose_…`` of the localiser,
    ``twist_…`` of the odometry, ``command_…`` and others of motors and brakes, ``rider_…`` of the
    device, ``people_…`` of detection, and clocks."""
    at: float = Field(ge=0.0)
    """s."""
    duration: float = Field(1.0, gt=0.0)
    """s."""
    magnitude: float | None = None
    """Intensity in the kind's own unit, if it has one; None: the kind's typical one."""

    @model_validator(mode="after")
    def _kind_exists_and_takes_the_magnitude(self) -> Self:
        from cohelm.simulation.faults.kinds import FAULT_KINDS  # noqa: PLC0415  # kinds need Fault

        kind = FAULT_KINDS.get(self.kind)
        if kind is None:
            raise ValueError(f"no fault is called {self.kind!r}{nearest(self.kind, FAULT_KINDS)}")
        refusal = "" if self.magnitude is None else kind.refusal(self.kind, self.magnitude)
        if refusal:
            raise ValueError(refusal)
        return self

    @property
    def size(self) -> float:
        """Magnitude, or the kind's typical one."""
        from cohelm.simulation.faults.kinds import FAULT_KINDS  # noqa: PLC0415  # kinds need Fault

        return FAULT_KINDS[self.kind].typical if self.magnitude is None else self.magnitude

    def active(self, time: float) -> bool:
        """Check that the fault is active at ``time``, s."""
        return self.at - _ROUNDING <= time < self.at + self.duration - _ROUNDING

    def since(self, time: float) -> float:
        """Time since the onset, s, ≥ 0."""
        return max(time - self.at, 0.0)
