"""Interfaces of platforms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from cohelm.messages import Decision, Observation
from cohelm.scenarios import RideSetup
from cohelm.simulation import GroundTruth, NewPedestrian


class SimulatedWorld(Protocol):
    """Abilities that only a simulation has."""

    @property
    def truth(self) -> GroundTruth:
        """True state; not for the navigator."""
        ...

    @property
    def shut(self) -> frozenset[int]:
        """Indices of the doors that are shut."""
        ...

    def spawn(self, new: NewPedestrian) -> int:
        """Add a pedestrian between two steps, and return their index."""
        ...

    def set_door(self, door: int, *, shut: bool) -> bool:
        """Shut or open a door; returns True if it moved."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Capabilities:
    """Abilities of a platform beyond observing and moving."""

    name: str
    """Name for the rider and for recordings."""
    world: SimulatedWorld | None = None
    """Simulated world with its ground truth; None: a real chair, or a simulator behind a network.

    With a world, time passes only in ``apply``: the ride can be paused and restarted."""
    wait: Callable[[float, float], float | None] | None = None
    """Wait for a reading of the leading sensor; None: control steps come every 0.05 s.

    ``wait(after, timeout)`` returns the arrival time of the newest reading that ``observe`` has not
    returned yet, by ``time.monotonic()``, as soon as it is later than ``after``; None after
    ``timeout``. See ``LeadingReadings``."""

    @property
    def simulation(self) -> bool:
        """True if the chair is simulated in this process."""
        return self.world is not None


class Platform(Protocol):
    """Chair that is ready to drive.

    A ride calls ``observe`` once, then ``apply`` once, in each control step. A step begins 0.05 s
    after the last one, or with a reading of the leading sensor (:attr:`Capabilities.wait`). Neither
    call waits: together they take a few milliseconds.
    """

    @property
    def capabilities(self) -> Capabilities:
        """Abilities; the same for the life of the platform."""
        ...

    def observe(self) -> Observation:
        """Return the newest pose, twist and stick, and the readings since the last ``apply``.

        All times are of one clock that starts near 0 and never runs backwards. A second call
        before ``apply`` may return newer values; it never loses a reading of the first one.
        An input that never came has the time −inf, or is None.

        Raises:
            PlatformError: The chair is lost.
        """
        ...

    def apply(self, decision: Decision) -> None:
        """Send a twist to the wheels; it holds until the next one, at most 0.25 s.

        Raises:
            PlatformError: The chair is lost.
        """
        ...

    def close(self) -> None:
        """Stop the wheels and release everything; may be called twice."""
        ...


class PlatformPlugin(Protocol):
    """Entry point of ``cohelm.platforms``: parameters that can open a platform."""

    simulated: bool
    """True if its platforms have a simulated world; known without opening one."""

    def open(self, setup: RideSetup) -> Platform:
        """Return the platform of a ride, at its start and ready to drive.

        Raises:
            PlatformError: It does not answer, or does not fit the ride.
        """
        ...
