"""Single-switch scanning: four directions light up in turn; the button drives the lit one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, replace, value
from cohelm.config import Model
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.rider_input import IDEAL, BaseRider, base_rider, deflected

DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""In scanning order: forward, left, back, right."""
_FORWARD, _LEFT, _BACK, _RIGHT = range(4)
_STOP = -1
_ROUNDING = 1e-9  # s; times are sums of float steps


class OneSwitch:
    """Waits for the desired direction, presses the button, and holds it while it is right.

    While the button is held the chair drives in the lit direction. When it is released the chair
    stops, and the scan begins again at forward.
    """

    class Parameters(Model):
        """Scan, reaction and thresholds."""

        base: BaseRider = Field(default_factory=lambda: {**IDEAL, "slowing_distance": 0.2})
        """Rider whose stick input is approximated; a button does not slow down before the goal."""
        scan_period: float = Field(1.0, gt=0.0, le=10.0)
        """Time for which each direction is lit, s: the time to press divided by 0.65 (Simpson,
        Koester and LoPresti, 2006)."""
        reaction_time: float = Field(0.65, ge=0.0, le=5.0)
        """From perception to pressing or releasing, s (assumed)."""
        drive_deflection: float = Field(0.6, gt=0.0, le=1.0)
        """Deflection of forward and back, share of full (assumed)."""
        turn_deflection: float = Field(0.4, gt=0.0, le=1.0)
        """Deflection of left and right, share of full (assumed)."""
        turn_start_angle: float = Field(0.5, gt=0.0, le=2.0)
        """Angle of the stick from forward above which the chair turns first, rad (assumed)."""
        turn_end_angle: float = Field(0.25, ge=0.0, le=1.0)
        """Angle below which a turn ends, rad (assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p, now = self.parameters, view.time
        last: _Memory = memory or _Memory(
            base=None, scan_start=now, held=_STOP, desired=_STOP, since=now, right_at=now
        )
        act = self.base.act(_predicted(view, p.reaction_time), last.base, rng)
        if act.command is None:
            return act
        desired = self._direction(act.command.deflection, last.desired)
        since = last.since if desired == last.desired else now
        held, scan_start = last.held, last.scan_start
        right_at = now if held == desired else last.right_at
        lit, lit_since = self._lit(now - scan_start)
        reacts = now - max(since, scan_start + lit_since) >= p.reaction_time - _ROUNDING
        if held == _STOP and desired == lit and reacts:
            held, right_at = desired, now
        elif held != _STOP and now - right_at > p.reaction_time + _ROUNDING:
            held, scan_start = _STOP, now
        deflection = np.zeros(2)
        if held != _STOP:
            deflection = DIRECTIONS[held] * np.array([p.drive_deflection, p.turn_deflection])
        kept = _Memory(
            base=act.memory,
            scan_start=scan_start,
            held=held,
            desired=desired,
            since=since,
            right_at=right_at,
        )
        return deflected(view, deflection, kept)

    def _lit(self, scanning: float) -> tuple[int, float]:
        """Return the lit direction, and the time of the scan at which it lit up, s."""
        count = math.floor((scanning + _ROUNDING) / self.parameters.scan_period)
        return count % 4, count * self.parameters.scan_period

    def _direction(self, deflection: Floats, last: int) -> int:
        """Return the direction nearest to a stick deflection (2,), with hysteresis."""
        if not deflection.any():
            return _STOP
        p, angle = self.parameters, math.atan2(deflection[1], deflection[0])
        if abs(angle) > math.pi - p.turn_start_angle:
            return _BACK
        side = _LEFT if angle > 0.0 else _RIGHT
        still_turns = last == side and abs(angle) > p.turn_end_angle
        return side if still_turns or abs(angle) > p.turn_start_angle else _FORWARD


def _predicted(view: RiderView, reaction_time: float) -> RiderView:
    """View at the end of the reaction time, which a practised rider anticipates."""
    x, y, heading = view.pose
    travel = view.twist[0] * reaction_time
    half = heading + view.twist[2] * reaction_time / 2.0
    pose = np.array(
        [
            x + travel * math.cos(half),
            y + travel * math.sin(half),
            heading + view.twist[2] * reaction_time,
        ]
    )
    return replace(view, pose=pose)


@value
class _Memory:
    base: Any
    scan_start: float
    """s."""
    held: int
    """Direction of motion."""
    desired: int
    since: float
    """Time since which it is desired, s."""
    right_at: float
    """Last time at which the held direction was the desired one, s."""
