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

import os
import tempfile
import threading
import time
import weakref
from collections.abc import Callable
from pathlib import Path

from cohelm.arrays import value
from cohelm.driving.asking import Charge
from cohelm.driving.audit import Audit
from cohelm.driving.chair import STEP, Chair
from cohelm.driving.crew import Crew
from cohelm.driving.files import reserved
from cohelm.driving.hearing import Hearing
from cohelm.driving.limits import InForce, LimitsRise
from cohelm.driving.loop import Loop, LoopEffects
from cohelm.driving.messages import (
    Configured,
    Echo,
    FromPage,
    Limits,
    Refused,
    RiderSettings,
    Role,
    Scene,
    Simulate,
    ToPage,
    Welcome,
)
from cohelm.driving.outings import Outings
from cohelm.driving.playing import Playing
from cohelm.driving.pricing import Pricing
from cohelm.driving.scenery import scenery_of
from cohelm.driving.sessions import Sessions
from cohelm.driving.setup import DriveSetup
from cohelm.driving.thinking import Thinking
from cohelm.evaluation.processes import compiled

_INNERMOST = "quadratic.*"
"""Where a navigator was compiled before, so was the local planner's inner loop."""
Listener = Callable[[ToPage, str | None], None]
"""Told each message and for whom it is; None: for everybody who has joined."""


@value
class Health:
    """How the ride's machinery does."""

    ready: bool
    """The chair could drive; else it is getting ready."""
    trouble: str
    """Why it never will; empty: it may."""
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
        CohelmError: if the scenario names what there is not, or the folder cannot be written or
            is in use by another drive: limits of one would not hold in the other.
    """

    def __init__(self, setup: DriveSetup) -> None:
        cold = not compiled(_INNERMOST)  # before the scenery compiles what little it needs
        scenery = scenery_of(setup.scenario, setup.seed)
        self._scene, self._png = scenery.scene, scenery.png
        self._spare: tempfile.TemporaryDirectory[str] | None = None
        if setup.folder is None:
            self._spare = tempfile.TemporaryDirectory(prefix="cohelm-")
        folder = setup.folder or Path(self._spare.name if self._spare else "")
        self._reserved = weakref.finalize(self, os.close, reserved(folder))
        self._audit, self._sessions = Audit(folder), Sessions(folder)
        profile = setup.scenario.profile
        self._in_force = InForce(
            setup.folder, scenery.robot, profile, limits=setup.limits, rider=setup.rider
        )
        self._listeners: tuple[Listener, ...] = ()
        self._configuring = threading.Lock()
        charge = Charge(scenario=setup.scenario, seed=setup.seed, record=setup.record)
        pricing = Pricing(charge, self._tell)
        crew = Crew(
            thinking=Thinking(charge),
            pricing=pricing,
            playing=Playing(setup.scenario),
            outings=Outings(self._sessions, self._in_force, self._tell, STEP),
        )
        self._thinking = crew.thinking
        effects = LoopEffects(crew.outings)
        note = self._audit.note
        floor = self._scene.floor
        hearing = Hearing(scenery.places, self._in_force, self._tell, note, effects, floor)
        chair = Chair(hearing, self._in_force, profile, crew, tell=self._tell)
        self._loop = Loop(
            chair, hearing, crew, seed=setup.seed, cold=cold, tell=self._tell, note=note
        )
        effects.loop, effects.pricing = self._loop, pricing
        self._closed = False

    def start(self) -> None:
        """Begin: the chair's thread, and the navigator in a process of its own.

        Returns at once. Until all is compiled and warm, which takes a minute or two the first
        time, the chair stands and ``State.why`` says so.
        """
        self._audit.note("chair", "started", scene=self._scene.name, seed=self._scene.seed)
        self._loop.start()

    def close(self) -> None:
        """Stop the chair, end the ride and all processes; may be called twice."""
        if self._closed:
            return
        self._closed = True
        self._loop.close()
        self._audit.note("chair", "closed")
        self._sessions.close()
        self._audit.close()
        self._reserved()
        if self._spare is not None:
            self._spare.cleanup()

    def scene(self) -> Scene:
        """What does not change while the chair drives; known before :meth:`start`."""
        return self._scene

    def floor_png(self) -> bytes:
        """The map as a grey PNG: 0 occupied, 128 unknown, 255 free; its first row is the top."""
        return self._png

    def listen(self, callback: Listener) -> None:
        """Tell ``callback`` every message from now on.

        It is called from the chair's thread and, for answers that need no chair (Welcome, Route,
        Configured, Echo), from the caller's own before the call returns. It must not wait, and must
        not raise.
        """
        self._listeners = (*self._listeners, callback)

    def joined(self, client: str, role: Role) -> None:
        """A page has come; it is told Welcome and the route before this returns.

        Args:
            client: a name of its own for each connection; never used again.
            role: as it signed in.
        """
        welcome = Welcome(
            client=client, role=role, scene=self._scene, limits=self.limits, rider=self.rider
        )
        self._tell(welcome, client)
        self._tell(self._loop.chair.view.route(), client)
        self._loop.say(lambda hearing: hearing.joined(client, role))

    def left(self, client: str) -> None:
        """A page's connection is gone; where it drove, the chair stops."""
        self._loop.say(lambda hearing: hearing.left(client))

    def heard(self, client: str, message: FromPage, at: float | None = None) -> None:
        """A page said something; answers come through the listener.

        Args:
            client: that has joined.
            message: checked already.
            at: when it arrived, by ``time.monotonic()``, s; None: now.
        """
        if isinstance(message, Echo):
            self._tell(message, client)
            return
        came = time.monotonic() if at is None else at
        if not isinstance(message, Simulate):
            self._loop.say(lambda hearing: hearing.heard(client, message, came))
        elif not self._loop.bid(lambda hearing: hearing.heard(client, message, came)):
            text = "That is more than I can do at once."
            self._tell(Refused(id=message.id, code="too_many", text=text), client)

    @property
    def limits(self) -> Limits:
        """In force now."""
        return self._in_force.limits

    def set_limits(self, limits: Limits, who: str) -> None:
        """Change what the chair may do; everybody is told (``Configured``), and the audit log.

        Args:
            limits: bounded by what the robot can do.
            who: for the audit log.

        Raises:
            LimitsRise: if one would become looser while the chair moves.
            StoreError: if they cannot be kept; those before stay in force.
        """
        try:
            before = self._in_force.set_limits(limits, lambda: not self._loop.chair.moves)
        except LimitsRise:
            self._audit.note(who, "limits_refused", wanted=limits.model_dump())
            raise
        after = self.limits.model_dump()
        self._audit.note(who, "limits", before=before.model_dump(), after=after)
        self._configured()

    @property
    def rider(self) -> RiderSettings:
        """In force now."""
        return self._in_force.rider

    def set_rider(self, rider: RiderSettings, who: str) -> None:
        """Change how the rider's hand is understood; everybody is told, and the audit log.

        Raises:
            StoreError: if they cannot be kept; those before stay in force.
        """
        before = self._in_force.set_rider(rider)
        self._audit.note(who, "rider", before=before.model_dump(), after=rider.model_dump())
        self._configured()

    @property
    def sessions(self) -> Sessions:
        """The rides that are kept."""
        return self._sessions

    @property
    def audit(self) -> Audit:
        """Who drove and who changed what: append-only."""
        return self._audit

    @property
    def health(self) -> Health:
        """How the ride's machinery does."""
        loop = self._loop
        return Health(
            ready=loop.ready and not loop.trouble,
            trouble=loop.trouble,
            ticks=loop.chair.ticks,
            missed=loop.counts.missed,
            longest_streak=loop.counts.longest,
            stops=loop.chair.stops,
            restarts=max(self._thinking.begun - 1, 0),
        )

    @property
    def navigator_pid(self) -> int | None:
        """Of the navigator's process; None where there is none just now."""
        return self._thinking.pid

    def _configured(self) -> None:
        with self._configuring:
            self._tell(Configured(limits=self.limits, rider=self.rider), None)

    def _tell(self, message: ToPage, client: str | None) -> None:
        for listener in self._listeners:
            listener(message, client)
