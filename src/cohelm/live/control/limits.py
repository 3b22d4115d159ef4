"""Limits and rider's settings in force, which only the therapist changes.

A limit may be tightened at any time and loosened only while the chair stands: more speed, more
acceleration and less distance from people are looser. A tighter limit takes effect before it is
stored, and also if it cannot be; a looser one only once it is on disk. A file that cannot be read
is never silently replaced by looser defaults.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

from pydantic import ValidationError

from cohelm.config import Model
from cohelm.errors import CohelmError, StoreError
from cohelm.live.messages import Limits, Pace, RiderSettings
from cohelm.live.messages.scene import ACCELERATION_LIMITS, MAX_DEAD_ZONE, MIN_SPEED_LIMIT
from cohelm.live.sessions.database import Database
from cohelm.messages import RiderProfile
from cohelm.robots import Robot

_NAME = "settings"
OVER_EDGES = 20.0
"""Time for which a therapist can allow edges of the floor, s (as LUCI's override)."""
PACES = {"slow": 0.4, "normal": 0.7, "brisk": 1.0}
"""Speeds that the rider chooses from, m/s; assumed. Limits and robot bound them."""


class LimitsLoosened(CohelmError):
    """A limit would become looser while the chair moves; nothing was changed."""

    code: ClassVar[str] = "limits_loosened"


class ChairMoves(CohelmError):
    """Possible only while the chair stands; nothing was changed."""

    code: ClassVar[str] = "chair_moves"


class StoredSettings(Model):
    """Stored settings."""

    limits: Limits
    rider: RiderSettings
    person: str = ""
    """Id of the rider, see ``sessions.riders``; empty: nobody was chosen."""


class ActiveSettings:
    """Settings in force. Reading never waits, and tightening a limit does not wait for the disk.

    Args:
        folder: Data folder; None: nothing is stored.
        robot: Bounds the limits.
        profile: Source of the defaults if nothing is stored yet.
        limits, rider: Initial values; None: the stored ones, else the defaults.

    Raises:
        StoreError: There are stored settings, and they cannot be read.
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
        self._database = Database(folder) if folder is not None else None
        self._lock, self._disk = threading.Lock(), threading.Lock()
        self._error = ""
        self.defaults = defaults(robot, profile or RiderProfile())
        """Settings of a chair without a chosen rider."""
        stored = _read(self._database) if self._database is not None else None
        first = stored or self.defaults
        self._current = StoredSettings(
            limits=bounded(limits or first.limits, robot),
            rider=rider or first.rider,
            person=first.person,
        )
        self.over_edges_until = -math.inf
        """Time until which edges of the floor may be crossed, s of the control loop's clock."""
        self._stored: StoredSettings | None = stored
        """None: there are none yet, and none are needed for the defaults."""

    @property
    def limits(self) -> Limits:
        """Limits in force."""
        return self._current.limits

    @property
    def rider(self) -> RiderSettings:
        """Rider's settings in force."""
        return self._current.rider

    @property
    def person(self) -> str:
        """Id of the rider; empty: nobody was chosen."""
        return self._current.person

    @property
    def error(self) -> str:
        """Reason why the limits in force are not stored; empty if they are."""
        return self._error

    def set_limits(self, limits: Limits, standing: Callable[[], bool]) -> Limits:
        """Change the limits, bounded by the robot's, and return the previous ones.

        What is tighter takes effect at once. If it cannot be stored, :attr:`error` says so, and
        :meth:`retry` tries again.

        Args:
            limits: Requested limits.
            standing: Returns True while the chair stands; called only if a limit is loosened.

        Raises:
            LimitsLoosened: A limit would be loosened while the chair moves; names it.
            StoreError: Looser limits cannot be stored; the previous ones stay in force.
        """
        with self._lock:
            before, requested = self._current.limits, bounded(limits, self._robot)
            _check_standing(before, requested, standing)
            tight = tightest(before, requested)
            self._current = self._current.model_copy(update={"limits": tight})
        try:
            self._store(requested)
        except StoreError as error:
            self._error = error.problem
            if tight == before:
                raise
            return before
        try:
            with self._lock:
                if self._current.limits == tight:  # else somebody has tightened them meanwhile
                    _check_standing(tight, requested, standing)
                    self._current = self._current.model_copy(update={"limits": requested})
        finally:
            self._store_in_force()
        return before

    def retry(self) -> None:
        """Store the settings in force if that has failed before; may wait for the disk."""
        if self._error:
            self._store_in_force()

    def set_rider(self, rider: RiderSettings) -> RiderSettings:
        """Change the rider's settings and return the previous ones.

        Raises:
            StoreError: The settings cannot be stored; the previous ones stay in force.
        """
        with self._lock:
            before = self._current.rider
        self._store(self.limits, rider)
        with self._lock:
            self._current = self._current.model_copy(update={"rider": rider})
        return before

    def choose(
        self,
        person: str,
        limits: Limits | None,
        rider: RiderSettings | None,
        standing: Callable[[], bool],
    ) -> None:
        """Choose who rides, with their limits and settings; None: those in force stay.

        All of it takes effect also if it cannot be stored, except for limits that are looser.
        :attr:`error` says so then, and :meth:`retry` tries again.

        Args:
            person: Id of the rider; empty: nobody.
            limits, rider: Limits, bounded by the robot's, and settings of the rider.
            standing: Returns True while the chair stands.

        Raises:
            ChairMoves: The chair moves; nothing was changed.
        """
        with self._lock:
            if not standing():
                raise ChairMoves("the rider can be changed only while the chair stands")
            before = self._current
            requested = bounded(limits or before.limits, self._robot)
            tight = tightest(before.limits, requested)
            self._current = StoredSettings(limits=tight, rider=rider or before.rider, person=person)
        try:
            self._store(requested)
        except StoreError as error:
            self._error = error.problem
            return
        with self._lock:
            if self._current.limits == tight and standing():
                self._current = self._current.model_copy(update={"limits": requested})
        self._store_in_force()

    def _store_in_force(self) -> None:
        """Write the settings in force where looser ones were written that did not come in force."""
        try:
            self._store(self.limits)
        except StoreError as error:
            self._error = error.problem

    def _store(self, limits: Limits, rider: RiderSettings | None = None) -> None:
        """Write the settings, unless they are stored already."""
        with self._disk:
            settings = StoredSettings(limits=limits, rider=rider or self.rider, person=self.person)
            if self._database is not None and settings != self._stored:
                self._database.set(_NAME, settings.model_dump_json())
            self._stored, self._error = settings, ""


def defaults(robot: Robot, profile: RiderProfile) -> StoredSettings:
    """Return the settings of a robot and a rider's profile."""
    minimum, maximum = ACCELERATION_LIMITS
    limits = Limits(
        max_speed=max(min(PACES["brisk"], robot.max_speed), MIN_SPEED_LIMIT),
        max_acceleration=min(max(robot.max_acceleration, minimum), maximum),
        min_distance=profile.social_distance,
    )
    rider = RiderSettings(
        tremor_filter=profile.tremor_filter, dead_zone=min(profile.dead_zone, MAX_DEAD_ZONE)
    )
    return StoredSettings(limits=bounded(limits, robot), rider=rider)


def bounded(limits: Limits, robot: Robot) -> Limits:
    """Bound the limits by those of the robot."""
    return Limits(
        max_speed=max(min(limits.max_speed, robot.max_speed), MIN_SPEED_LIMIT),
        max_acceleration=max(
            min(limits.max_acceleration, robot.max_acceleration), ACCELERATION_LIMITS[0]
        ),
        min_distance=limits.min_distance,
    )


def loosened(before: Limits, after: Limits) -> tuple[str, ...]:
    """Return the names of the limits that are looser than before."""
    return tuple(
        name
        for name, looser in (
            ("The speed", after.max_speed > before.max_speed),
            ("The acceleration", after.max_acceleration > before.max_acceleration),
            ("The distance from people", after.min_distance < before.min_distance),
        )
        if looser
    )


def tightest(one: Limits, other: Limits) -> Limits:
    """Return the tighter one of each limit."""
    return Limits(
        max_speed=min(one.max_speed, other.max_speed),
        max_acceleration=min(one.max_acceleration, other.max_acceleration),
        min_distance=max(one.min_distance, other.min_distance),
    )


def _check_standing(before: Limits, after: Limits, standing: Callable[[], bool]) -> None:
    looser = loosened(before, after)
    if looser and not standing():
        # One sentence for each, so that the page can translate it.
        texts = (f"{limit} can be loosened only while the chair stands." for limit in looser)
        raise LimitsLoosened(" ".join(texts))


def limited_profile(
    profile: RiderProfile, pace: Pace, limits: Limits, rider: RiderSettings
) -> RiderProfile:
    """Return the profile for a request: pace and rider's settings within the limits."""
    return profile.model_copy(
        update={
            "preferred_speed": min(PACES[pace], limits.max_speed),
            "social_distance": max(profile.social_distance, limits.min_distance),
            "tremor_filter": rider.tremor_filter,
            "dead_zone": rider.dead_zone,
        }
    )


def _read(database: Database) -> StoredSettings | None:
    """Read the stored settings; None if there are none."""
    older = database.folder / "settings.json"
    if older.exists():
        problem = "is of an older version; remove it, and set the limits again on the page"
        raise StoreError(problem, file=older)
    text = database.setting(_NAME)
    try:
        return None if text is None else StoredSettings.model_validate_json(text)
    except ValidationError:
        raise database.unreadable("the settings are damaged") from None
