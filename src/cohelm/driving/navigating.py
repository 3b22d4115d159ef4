"""The navigator in a process of its own: a question comes through a pipe, an answer goes back.

What decides comes first: an answer is on its way before log and recorder are told of it, and the
rubbish of a step is cleared away while the chair is not waiting.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection

import numpy as np

from cohelm.arrays import identical
from cohelm.driving.asking import Answer, Ask, Charge, Ready, Way
from cohelm.driving.logbook import Logbook
from cohelm.driving.previews import surroundings_of, wishes_to_try
from cohelm.driving.recording import Recording
from cohelm.driving.records import RideLog
from cohelm.driving.shown import (
    eta_of,
    groups_of,
    people_of,
    plan_of,
    remaining_of,
    trouble_of,
    way_of,
)
from cohelm.evaluation import Stage
from cohelm.evaluation.processes import end_with_owner, leave_interrupts
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Mode, Path, Request, RiderCommand
from cohelm.navigation import Navigator, Tick
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.simulation import World

_TICKS = 12
"""Steps of each way of driving that are tried before the chair is ready."""
_CLEARED = 20
"""Steps between two thorough clearings of rubbish."""


def serve(pipe: Connection, charge: Charge) -> None:
    """What the process does, until the other end of the pipe is gone."""
    leave_interrupts()
    end_with_owner(grace=3.0)
    stage = set_stage(charge.scenario, charge.seed)
    mind = Mind(stage)
    try:
        for what in warm(stage):
            pipe.send(Ready(done=False, what=what))
        with Recording(charge.record, stage) as recording:
            gc.collect()
            gc.freeze()
            gc.disable()
            pipe.send(Ready(done=True))
            while True:
                ask = pipe.recv()
                pipe.send(mind.answer(ask))
                mind.note(ask, recording)
                gc.collect(2 if ask.number % _CLEARED == 0 else 0)
    except (EOFError, OSError):
        return


class Mind:
    """A navigator with its last tick.

    Args:
        stage: floor, chair and parts.
    """

    def __init__(self, stage: Stage) -> None:
        self._navigator = Navigator(stage.navigator)
        self._last: Tick | None = None
        self._path: Path | None = None
        self._logbook = Logbook()
        self._logs = False
        self._log: RideLog | None = None

    def answer(self, ask: Ask) -> Answer:
        """One step, or a glance at what there is."""
        if ask.glance:
            return self._glance(ask)
        if ask.afresh:
            self._last = None
        request = replace(ask.request, farther=ask.distance)  # so that it is recorded, too
        tick = self._navigator.step(ask.observation, self._same(request), self._last)
        self._last = tick
        log, self._log = self._log, None
        return Answer(
            number=ask.number,
            errand=ask.errand,
            heard=ask.heard,
            decision=tick.decision,
            eta=eta_of(tick),
            arrived=tick.arrived,
            remaining=remaining_of(tick),
            trouble=trouble_of(tick),
            way=self._way(tick, afresh=ask.afresh),
            plan=plan_of(tick),
            people=people_of(tick),
            groups=groups_of(tick),
            log=log,
            surroundings=surroundings_of(tick, request) if ask.surroundings else None,
        )

    def note(self, ask: Ask, recording: Recording) -> None:
        """Put the step that was just answered down; a glance is none."""
        if ask.glance:
            return
        if ask.afresh:
            recording.afresh()
        if ask.end is not None and self._logs:
            self._log = self._logbook.end(ask.end)
            self._logs = False
        if ask.begin is not None:
            self._logbook.begin(*ask.begin)
            self._logs = True
        if self._last is None:
            return
        if self._logs:
            self._logbook.add(self._last, ask.truth)
        recording.add(self._last, ask.truth)

    def _glance(self, ask: Ask) -> Answer:
        """What a way is planned among since the last step; the navigator does none."""
        found = surroundings_of(self._last, ask.request) if self._last is not None else b""
        return Answer(
            number=ask.number,
            errand=ask.errand,
            heard=ask.heard,
            decision=stop(Reason.PAUSED),
            glance=True,
            surroundings=found,
        )

    def _same(self, request: Request) -> Request:
        """The request of before where it says the same, for whoever compares by identity."""
        last = self._last.request if self._last is not None else None
        return last if last is not None and identical(last, request) else request

    def _way(self, tick: Tick, *, afresh: bool) -> Way | None:
        """The route, where it is another one than was told last."""
        if tick.path is self._path and not afresh:
            return None
        self._path = tick.path
        if tick.path is None:
            return Way(points=(), without=(), length=0.0, extra=0.0)
        return way_of(tick.path)


def warm(stage: Stage) -> Iterator[str]:
    """Drive a little in every way, in a world that nobody sees, so that all is compiled and read.

    Yields what comes next, in words.
    """
    yield "world"
    world, mind = World(stage.world, stage.seed), Mind(stage)
    number = 0
    for what, request, stick in _ways_of_driving(stage):
        yield what
        for _ in range(_TICKS):
            seen = world.observe()
            hand = RiderCommand(heartbeat=seen.time, deflection=np.array(stick))
            ask = Ask(
                number=number,
                errand=0,
                observation=replace(seen, rider=hand),
                request=request,
                truth=world.truth,
                heard=0,
                distance=0.1 * (number % 2),
                surroundings=number % _TICKS == 0,
            )
            world.advance(mind.answer(ask).decision)
            number += 1


def _ways_of_driving(stage: Stage) -> Iterator[tuple[str, Request, tuple[float, float]]]:
    """(what it is, request, stick) each."""
    asked = replace(stage.request, wishes=(), mode=Mode.SHARED, speed_limit=0.7)
    nowhere = np.full(2, np.nan)
    yield "route", asked, (0.0, 0.0)
    yield "hand", asked, (0.5, 0.3)
    for wish in wishes_to_try(stage):
        yield wish.kind, replace(asked, wishes=(wish,)), (0.0, 0.0)
    yield "alone", replace(asked, mode=Mode.AUTONOMOUS), (0.0, 0.0)
    yield "held", replace(asked, speed_limit=0.0), (0.0, 0.0)
    for mode in (Mode.ASSISTED, Mode.MANUAL):
        yield mode.value, replace(asked, goal=nowhere, mode=mode), (0.4, -0.3)
