"""Riders of a drive: who rides, what their preset changes, and what is stored about them.

Every method may be called from any thread and waits for the disk, but never for the control loop.
The audit log gets the id of a rider, never the name.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

from cohelm.config import Model
from cohelm.errors import StoreError
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control_loop import ControlLoop
from cohelm.live.messages import Limits, RiderSettings
from cohelm.live.ride_tracker import RideTracker
from cohelm.live.sessions.audit import LogEvent
from cohelm.live.sessions.progress import RiderProgress, rider_progress
from cohelm.live.sessions.rider_export import rider_archive
from cohelm.live.sessions.riders import DamagedRider, RiderDraft, RiderPreset, RiderRecord
from cohelm.live.sessions.store import SessionStore
from cohelm.messages import Mode


class RiderList(Model):
    """All riders, and who rides."""

    riders: tuple[RiderRecord, ...]
    damaged: tuple[DamagedRider, ...]
    current: str
    """Id of the rider; empty: nobody was chosen."""


class DeletedRider(Model):
    """Result of the deletion of a rider."""

    sessions: int
    """Number of their sessions that were deleted."""
    unreadable: int
    """Number of sessions that may be theirs and stay, since it cannot be read whose they are."""


class RiderChoice:
    """Riders of a drive.

    Args:
        sessions: Stores riders and sessions.
        settings: Limits and settings in force.
        driver: Mission; belongs to the control thread.
        rides: Rides; belong to the control thread.
        loop: Control loop.
        log_event: Adds entries to the audit log.
        announce: Tells all pages the settings in force.
        modes: Modes that this chair has.
    """

    def __init__(
        self,
        sessions: SessionStore,
        settings: ActiveSettings,
        driver: DriverState,
        rides: RideTracker,
        loop: ControlLoop,
        *,
        log_event: LogEvent,
        announce: Callable[[], None],
        modes: Collection[Mode],
    ) -> None:
        self._sessions, self._settings, self._driver = sessions, settings, driver
        self._rides, self._loop, self._modes = rides, loop, modes
        self._log_event, self._announce = log_event, announce

    def list(self) -> RiderList:
        """Return all riders, and who rides."""
        riders, damaged = self._sessions.riders.list()
        return RiderList(riders=riders, damaged=damaged, current=self._settings.person)

    def restore(self) -> None:
        """Put mode and speed of who rode last in force; nobody rides if their record is gone."""
        rider = self._settings.person
        if not rider:
            return
        try:
            preset = self._sessions.riders.get(rider).preset
        except StoreError as error:
            if error.file is None:
                self._settings.choose("", None, None, lambda: True)
            return
        self._loop.call(lambda: self._begin(preset, other=False))

    def create(self, draft: RiderDraft, actor: str) -> RiderRecord:
        """Store a new rider; errors as in ``RiderStore.create``."""
        record = self._sessions.riders.create(draft)
        self._log_event(actor, "rider_created", rider=record.id)
        return record

    def change(self, rider: str, draft: RiderDraft, actor: str) -> RiderRecord:
        """Replace what is stored about a rider; errors as in ``RiderStore.change``.

        What is in force changes when the rider is chosen again.
        """
        record = self._sessions.riders.change(rider, draft)
        self._log_event(actor, "rider_changed", rider=rider)
        return record

    def choose(self, rider: str, actor: str) -> RiderList:
        """Choose who rides, and put their preset in force.

        For another rider the ride ends, destination and wishes are cleared, and the next ride
        begins a session of theirs.

        Args:
            rider: Id; empty: nobody, which keeps the limits and settings.
            actor: Name for the audit log.

        Raises:
            ChairMoves: The chair moves.
            StoreError: There is no such rider, or their file is damaged.
        """
        preset = self._sessions.riders.get(rider).preset if rider else None
        given = None if preset is None else (preset.limits, preset.settings)
        return self._choose(rider, preset, given, actor)

    def _choose(
        self,
        rider: str,
        preset: RiderPreset | None,
        given: tuple[Limits, RiderSettings] | None,
        actor: str,
    ) -> RiderList:
        """Choose who rides, with limits and settings; None: those in force stay."""
        before = self._settings.person
        limits, settings = given or (None, None)
        self._settings.choose(rider, limits, settings, lambda: not self._loop.cycle.moves)
        self._loop.call(lambda: self._begin(preset, other=rider != before))
        in_force = self._settings.limits.model_dump()
        self._log_event(actor, "rider_chosen", before=before, rider=rider, limits=in_force)
        self._announce()
        if rider != before:
            text = "Another rider was chosen. Destination and wishes are cleared."
            self._loop.announce("rider_chosen", text)
        return self.list()

    def delete(self, rider: str, actor: str) -> DeletedRider:
        """Delete a rider and all their sessions.

        If they ride now, nobody does afterwards, with the chair's own limits and settings.

        Raises:
            ChairMoves: The rider rides, and the chair moves.
            StoreError: There is no such rider, or something could not be deleted; the record is
                the last that goes, so that the deletion can be repeated.
        """
        self._sessions.riders.check(rider)
        if rider == self._settings.person:
            own = self._settings.defaults
            self._choose("", None, (own.limits, own.rider), actor)
        count = self._sessions.delete_of(rider)
        self._sessions.riders.remove(rider)
        unreadable = self._sessions.unreadable()
        self._log_event(actor, "rider_deleted", rider=rider, sessions=count, unreadable=unreadable)
        return DeletedRider(sessions=count, unreadable=unreadable)

    def progress(self, rider: str) -> RiderProgress:
        """Return the progress of a rider.

        Raises:
            StoreError: There is no such rider, or their file is damaged.
        """
        goals = self._sessions.riders.get(rider).goals
        return rider_progress(self._sessions.list_of(rider), goals)

    def export(self, rider: str, actor: str) -> bytes:
        """Return a ZIP archive of all that is stored about a rider.

        Raises:
            StoreError: There is no such rider, or their file is damaged.
        """
        content = rider_archive(self._sessions, rider)
        self._log_event(actor, "rider_exported", rider=rider)
        return content

    def _begin(self, preset: RiderPreset | None, *, other: bool) -> None:
        """Put mode and speed in force, in the control thread."""
        if other:
            self._rides.end("cancelled")
            self._driver.clear_mission()
        if preset is None:
            return
        mission = replace(self._driver.mission, pace=preset.pace)
        mode = preset.mode if preset.mode in self._modes else mission.mode
        self._driver.mission = replace(mission, mode=mode)
