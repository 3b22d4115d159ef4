"""The limits and the rider's settings in force, which only the therapist changes.

A limit may be tightened at any time and loosened only while the chair stands: more speed, more
acceleration and less distance from people are looser. They outlive the program; a file of them that
cannot be read is never replaced by looser defaults in silence.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from pydantic import ValidationError

from cohelm.config import Model
from cohelm.driving.files import own_folder, write_whole
from cohelm.driving.messages import Limits, Pace, RiderSettings
from cohelm.driving.setup import PACES
from cohelm.errors import CohelmError, StoreError
from cohelm.messages import RiderProfile
from cohelm.robots import Robot


class LimitsRise(CohelmError):
    """A limit would become looser while the chair moves; says which, and nothing was changed."""

    code: ClassVar[str] = "limits_rise"


class Settings(Model):
    """What is kept of it in a file."""

    version: int = 1
    limits: Limits
    rider: RiderSettings


class InForce:
    """What is in force now. Reading waits for nobody; a change is on the disk before it counts.

    Args:
        folder: keeps ``settings.json``; None: nothing is kept.
        robot: bounds what is possible.
        profile: where nothing is kept yet, the rider's; see :func:`defaults`.
        limits, rider: in force at first; None: those that are kept, else the defaults.

    Raises:
        StoreError: if the file is there and does not read.
    """

    def __init__(
        self,
        folder: Path | None,
        robot: Robot,
        profile: RiderProfile | None = None,
        *,
        limits: Limits | None = None,
        rider: RiderSettings | None = None,
    ) -> None:
        self._robot = robot
        self._file = own_folder(folder) / "settings.json" if folder is not None else None
        self._lock = threading.Lock()
        kept = _read(self._file) if self._file is not None else None
        first = kept or defaults(robot, profile or RiderProfile())
        self._now = Settings(
            limits=bounded(limits or first.limits, robot), rider=rider or first.rider
        )

    @property
    def limits(self) -> Limits:
        """Those of now."""
        return self._now.limits

    @property
    def rider(self) -> RiderSettings:
        """Those of now."""
        return self._now.rider

    def set_limits(self, limits: Limits, standing: Callable[[], bool]) -> Limits:
        """Put others in force, bounded by what the robot can.

        Args:
            limits: wanted.
            standing: whether the chair stands now; asked only where a limit is loosened.

        Returns:
            those before.

        Raises:
            LimitsRise: if one would be loosened while the chair moves; names it.
            StoreError: if they cannot be kept; those before stay in force.
        """
        with self._lock:
            before, wanted = self._now.limits, bounded(limits, self._robot)
            looser = loosened(before, wanted)
            if looser and not standing():
                raise LimitsRise(
                    f"{' and '.join(looser)} can be loosened only while the chair stands"
                )
            self._put(self._now.model_copy(update={"limits": wanted}))
            return before

    def set_rider(self, rider: RiderSettings) -> RiderSettings:
        """Put other settings in force, at any time; those before.

        Raises:
            StoreError: if they cannot be kept; those before stay in force.
        """
        with self._lock:
            before = self._now.rider
            self._put(self._now.model_copy(update={"rider": rider}))
            return before

    def _put(self, settings: Settings) -> None:
        if self._file is not None:
            write_whole(self._file, settings.model_dump_json(indent=1).encode() + b"\n")
        self._now = settings


def defaults(robot: Robot, profile: RiderProfile) -> Settings:
    """What a robot and a rider's profile say before a therapist does."""
    limits = Limits(
        max_speed=max(min(PACES["brisk"], robot.max_speed), 0.1),
        max_acceleration=min(max(robot.max_acceleration, 0.1), 2.0),
        min_distance=profile.social_distance,
    )
    rider = RiderSettings(
        tremor_filter=profile.tremor_filter, dead_zone=min(profile.dead_zone, 0.6)
    )
    return Settings(limits=bounded(limits, robot), rider=rider)


def bounded(limits: Limits, robot: Robot) -> Limits:
    """The limits, or what the robot can where that is less."""
    return Limits(
        max_speed=max(min(limits.max_speed, robot.max_speed), 0.1),
        max_acceleration=max(min(limits.max_acceleration, robot.max_acceleration), 0.1),
        min_distance=limits.min_distance,
    )


def loosened(before: Limits, after: Limits) -> tuple[str, ...]:
    """Which limits would let the chair do more than before, in words."""
    return tuple(
        name
        for name, looser in (
            ("the speed", after.max_speed > before.max_speed),
            ("the acceleration", after.max_acceleration > before.max_acceleration),
            ("the distance from people", after.min_distance < before.min_distance),
        )
        if looser
    )


def profile_under(
    profile: RiderProfile, pace: Pace, limits: Limits, rider: RiderSettings
) -> RiderProfile:
    """The profile that a request carries: the pace and the rider's settings within the limits."""
    return profile.model_copy(
        update={
            "preferred_speed": min(PACES[pace], limits.max_speed),
            "social_distance": max(profile.social_distance, limits.min_distance),
            "tremor_filter": rider.tremor_filter,
            "dead_zone": rider.dead_zone,
        }
    )


def _read(file: Path) -> Settings | None:
    """What the file keeps; None: there is no file."""
    try:
        return Settings.model_validate(json.loads(file.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return None
    except (OSError, ValueError, ValidationError):
        raise StoreError(
            "does not read; mend it, or remove it to begin with the chair's own limits", file=file
        ) from None
