"""A live ride, as whoever serves it sees it: what is said goes in, what is to be told comes out.

    drive = Drive(DriveSetup(scenario=load_scenario("hospital")))
    drive.listen(lambda message, client: ...)    # from the chair's thread: hop to your own
    drive.start()                                # returns at once; State.why says "getting ready"
    drive.joined("a", "driver")                  # answered with Welcome before it returns
    drive.heard("a", Beat(seq=0, sent=0.0), time.monotonic())
    drive.close()

No call waits for the chair; each may come from any thread.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from cohelm.arrays import value
from cohelm.driving.messages import FromPage, Limits, RiderSettings, Role, Scene, ToPage
from cohelm.driving.setup import DriveSetup
from cohelm.errors import CohelmError

Listener = Callable[[ToPage, str | None], None]
"""Told each message and for whom it is; None: for everybody who has joined."""


class LimitsRise(CohelmError):
    """A limit would become looser while the chair moves; nothing was changed."""

    code = "limits_rise"


@value
class Health:
    """How the ride's machinery does."""

    ready: bool
    """The chair could drive; else it is getting ready."""
    ticks: int
    """Steps of the chair so far."""
    missed: int
    """Of them, those that began later than their period was long."""
    longest_streak: int
    """Most missed in a row."""
    stops: int
    """How often the watchdog stopped the chair."""
    restarts: int
    """How often the navigator was started anew."""


class Drive:
    """A chair that a person drives live, in simulation.

    Args:
        setup: scenario, seed, and where things are kept.

    Raises:
        CohelmError: if the scenario names what there is not.
    """

    def __init__(self, setup: DriveSetup) -> None:
        raise NotImplementedError

    def start(self) -> None:
        """Begin: the chair's thread, and the navigator in a process of its own.

        Returns at once. Until all is compiled and warm, which takes a minute or two the first
        time, the chair stands and ``State.why`` says so.
        """

    def close(self) -> None:
        """Stop the chair, end the ride and all processes; may be called twice."""

    def scene(self) -> Scene:
        """What does not change while the chair drives; known before :meth:`start`."""
        raise NotImplementedError

    def floor_png(self) -> bytes:
        """The map as a grey PNG: 0 occupied, 128 unknown, 255 free; its first row is the top."""
        raise NotImplementedError

    def listen(self, callback: Listener) -> None:
        """Tell ``callback`` every message from now on.

        It is called from the chair's thread, from threads of the ride's own, and, for answers that
        need no chair (Welcome, Echo), from the caller's own before the call returns. It must not
        wait, and must not raise.
        """

    def joined(self, client: str, role: Role) -> None:
        """A page has come; it is told Welcome before this returns, and then the route.

        Args:
            client: a name of its own for each connection; never used again.
            role: as it signed in.
        """

    def left(self, client: str) -> None:
        """A page's connection is gone; where it drove, the chair stops."""

    def heard(self, client: str, message: FromPage, at: float) -> None:
        """A page said something; answers come through the listener.

        Args:
            client: that has joined.
            message: checked already.
            at: when it arrived, by ``time.monotonic()``, s.
        """

    @property
    def limits(self) -> Limits:
        """In force now."""
        raise NotImplementedError

    def set_limits(self, limits: Limits, who: str) -> None:
        """Change what the chair may do; everybody is told (``Configured``), and the audit log.

        Args:
            limits: bounded by what the robot can do.
            who: for the audit log.

        Raises:
            LimitsRise: if one would become looser while the chair moves.
        """

    @property
    def rider(self) -> RiderSettings:
        """In force now."""
        raise NotImplementedError

    def set_rider(self, rider: RiderSettings, who: str) -> None:
        """Change how the rider's hand is understood; everybody is told, and the audit log."""

    @property
    def sessions(self) -> Any:
        """The rides that are kept: list, summary, HTML, CSV, PNG, and all deleted at once."""
        raise NotImplementedError

    @property
    def audit(self) -> Any:
        """Who drove and who changed what: append-only."""
        raise NotImplementedError

    @property
    def health(self) -> Health:
        """How the ride's machinery does."""
        raise NotImplementedError

    @property
    def navigator_pid(self) -> int | None:
        """Of the navigator's process; None where there is none just now."""
        raise NotImplementedError
