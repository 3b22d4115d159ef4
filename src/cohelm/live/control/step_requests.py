"""Requests to the navigator, made from world, driver and settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.live.control import driver_link
from cohelm.live.control.driver_link import LinkState
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.ipc import StepRequest
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.mission import request_of
from cohelm.live.control.world_factory import LiveWorld
from cohelm.messages import Observation, PointCloud, RiderCommand, RiderProfile, Scan

_MAX_UNSENT = 8
"""Maximum number of scans, and of clouds, kept for a navigator that is late."""


MAX_SKIPPED = 2
"""Number of skipped observations from which the last command does not explain the motion."""


class UnsentReadings:
    """Scans and clouds of the steps in which the navigator was busy, and their number."""

    def __init__(self) -> None:
        self._scans: tuple[Scan, ...] = ()
        self._clouds: tuple[PointCloud, ...] = ()
        self._skipped = 0
        """Number of observations since the last one that was sent."""

    @property
    def waiting(self) -> bool:
        """True if there are readings."""
        return bool(self._scans or self._clouds)

    def keep(self, observation: Observation) -> None:
        """Keep the readings of an observation that was not sent; too old ones are dropped."""
        self._skipped += 1
        self._scans = (*self._scans, *observation.scans)[-_MAX_UNSENT:]
        self._clouds = (*self._clouds, *observation.clouds)[-_MAX_UNSENT:]

    def take(self, observation: Observation) -> Observation:
        """Return an observation with all readings, which are kept no longer.

        After several steps without the navigator the watchdog may have commanded a stop that it
        does not know of: then the command that the wheels have followed counts as unknown.
        """
        scans, clouds, skipped = self._scans, self._clouds, self._skipped
        self.clear()
        return replace(
            observation,
            command=None if skipped >= MAX_SKIPPED else observation.command,
            scans=(*scans, *observation.scans),
            clouds=(*clouds, *observation.clouds),
        )

    def clear(self) -> None:
        """Drop all readings."""
        self._scans, self._clouds, self._skipped = (), (), 0


def step_request(
    step_id: int,
    world: LiveWorld,
    driver: DriverState,
    settings: ActiveSettings,
    profile: RiderProfile,
    *,
    now: float,
    moves: bool,
    stop: bool = False,
) -> StepRequest:
    """Return the request for one step.

    Args:
        step_id: ``CycleState.ticks`` of the step.
        world: Source of the observation.
        driver: Link and mission.
        settings: Limits and rider's settings.
        profile: Profile of the scenario's rider.
        now: s of the control loop's clock.
        moves: True if the chair may move; then the observation has the driver's stick.
        stop: The chair waits for its driver after STOP or a fault, which is known so, see
            ``readiness.acknowledges``.
    """
    observation, link = world.observation, driver.link
    # The driver takes the place of the scenario's rider.
    stick = _rider_command(observation, link, now) if moves else None
    return StepRequest(
        step_id=step_id,
        mission_version=driver.mission.version,
        observation=replace(observation, rider=stick),
        request=request_of(
            driver.mission,
            profile,
            settings.limits,
            settings.rider,
            moves=moves,
            stop=stop,
            over_edges=now < settings.over_edges_until,
        ),
        truth=world.truth,
        heartbeat_seq=driver_link.current_heartbeat(link, now).seq if moves else -1,
    )


def _rider_command(observation: Observation, link: LinkState, now: float) -> RiderCommand:
    """Return the driver's stick, with its heartbeat in the time of the platform."""
    age = max(now - link.heartbeat_at, 0.0)
    deflection = np.array(driver_link.deflection(link, now))
    return RiderCommand(heartbeat=observation.time - age, deflection=deflection)
