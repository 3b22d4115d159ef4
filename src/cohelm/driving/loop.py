"""The chair's thread: absolute deadlines, what pages said in between, processes looked after."""

from __future__ import annotations

import contextlib
import gc
import logging
import math
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.driving.chair import STEP, Chair
from cohelm.driving.crew import Crew
from cohelm.driving.hearing import Hearing, Note, Tell
from cohelm.driving.messages import Notice, Simulate, Want
from cohelm.driving.outings import Outings
from cohelm.driving.pricing import Pricing
from cohelm.errors import CohelmError
from cohelm.reasons import Reason
from cohelm.safety import stop

_log = logging.getLogger(__name__)
FIRST_TIME = "The first time this takes a minute or two."
MOST_ERRANDS = 64
"""That may wait for the chair to have time for them; more are refused."""
QUICK = 0.002
"""After an errand that took longer, s, the next one waits …"""
LAST = 1.0
"""For the navigator to hand over the log of the last ride, s."""
REST = 9.0
"""… for so many times as long as it took, so that the chair keeps its time."""
Said = Callable[[Hearing], None]


class NotNow(CohelmError):
    """What cannot be done as things are just now."""

    code = "not_now"


@dataclass(slots=True)
class Counts:
    """Of deadlines."""

    missed: int = 0
    streak: int = 0
    longest: int = 0

    def note(self, *, missed: bool) -> None:
        """One more."""
        self.missed += missed
        self.streak = self.streak + 1 if missed else 0
        self.longest = max(self.longest, self.streak)


class Loop:
    """What happens 20 times a second, and whoever works for it aside.

    Args:
        chair, hearing: see there; they belong to this thread once it runs.
        crew: whoever works aside.
        seed: of the first world.
        cold: nothing is compiled yet.
        tell, note: listeners, audit log.
    """

    def __init__(
        self,
        chair: Chair,
        hearing: Hearing,
        crew: Crew,
        *,
        seed: int,
        cold: bool,
        tell: Tell,
        note: Note,
    ) -> None:
        self.chair, self._hearing = chair, hearing
        self._thinking, self._pricing, self._playing = crew.thinking, crew.pricing, crew.playing
        self._outings, self._seed, self._tell, self._note = crew.outings, seed, tell, note
        self._said: queue.SimpleQueue[Said] = queue.SimpleQueue()
        self._errands: queue.Queue[Said] = queue.Queue(MOST_ERRANDS)
        self._rests_until = -math.inf
        self._ends = threading.Event()
        self._ready, self._cold = False, cold
        self.counts = Counts()
        self.trouble = ""
        """Why the chair will never drive; empty: it may."""
        self._thread = threading.Thread(target=self._run, name="chair", daemon=True)

    @property
    def ready(self) -> bool:
        """Whether the chair could drive."""
        return self._thinking.ready and self._pricing.settled and self.chair.play is not None

    def start(self) -> None:
        """Begin."""
        if self._cold:
            _log.warning("compiling for this machine, once; it takes a minute or two")
        self.chair.preparing = FIRST_TIME if self._cold else ""
        self._playing.make(self._seed, self._compiled)
        self._thread.start()

    def close(self) -> None:
        """End, all processes too."""
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join()
        self._outings.lost()
        self._thinking.close()
        self._pricing.close()

    def say(self, said: Said) -> None:
        """Let something take effect in the chair's thread, before anything else."""
        self._said.put(said)

    def bid(self, said: Said) -> bool:
        """Let something take effect that may take a while; False: too much waits already.

        It never makes STOP, a beat or whoever takes the stick wait.
        """
        try:
            self._errands.put_nowait(said)
        except queue.Full:
            return False
        return True

    def begin_anew(self, seed: int | None) -> None:
        """Another world, when it is made.

        Raises:
            NotNow: if one is being made.
        """
        if self._playing.busy:
            raise NotNow("The simulation is beginning anew already.")
        self._seed = self._seed if seed is None else seed
        self.chair.waits = True
        self._playing.make(self._seed, lambda: True)

    def _compiled(self) -> bool:
        """Two processes that compile the same may spoil what is kept of it: all wait for one."""
        return self._thinking.ready or not self._cold

    def _run(self) -> None:
        due = time.monotonic()
        while not self._ends.is_set():
            begun = time.monotonic()
            try:
                self._look_after(begun)
                self._attend()
                self._run_errands()
                self.chair.step(due, self._attend)
            except Exception:
                _log.exception("the chair's loop has failed")
                self.chair.order = stop(Reason.NAVIGATOR_SILENT)
                self.trouble = "the chair's loop has failed; see the log"
                self._tell(Notice(code="broken", text="Something in me broke. I stand."), None)
                return
            if begun > due + STEP:  # what is lost is lost: no rush to catch up
                due = begun
            due += STEP
            now = time.monotonic()
            if self._ready:
                self.counts.note(missed=now > due)
            self._ends.wait(max(due - now, 0.0))
        self._finish()

    def _finish(self) -> None:
        """Let the ride that goes on end, and its log be handed over; the chair stands."""
        chair, end = self.chair, time.monotonic() + LAST
        chair.waits, chair.paused = True, False
        try:
            self._outings.end("left")
            while self._outings.owing and self._thinking.ready and time.monotonic() < end:
                chair.step(time.monotonic(), lambda: None)
        except Exception:
            _log.exception("the last ride could not be ended")

    def _attend(self) -> None:
        """Let what was said take effect, in its order."""
        with contextlib.suppress(queue.Empty):
            while True:
                self._effect(self._said.get_nowait())

    def _run_errands(self) -> None:
        """The same for what may take a while: no more of it than leaves the chair its time."""
        with contextlib.suppress(queue.Empty):
            while (began := time.monotonic()) >= self._rests_until:
                self._effect(self._errands.get_nowait())
                spent = time.monotonic() - began
                if spent > QUICK:
                    self._rests_until = began + (1.0 + REST) * spent

    def _effect(self, said: Said) -> None:
        """None of it ends the drive."""
        try:
            said(self._hearing)
        except Exception:
            _log.exception("what a page said could not take effect")

    def _look_after(self, now: float) -> None:
        """Processes that become ready or are gone, and worlds that are made."""
        if self._thinking.attend(now):
            self.chair.forgets()
            if self._thinking.begun > 1:
                self.chair.hold(Reason.NAVIGATOR_SILENT)
                self._tell(Notice(code="navigator_back", text="I can think again."), None)
        self._lost()
        if self._compiled():
            self._pricing.begin()
        self._pricing.attend()
        self._world()
        if self.ready and not self._ready:
            self._ready = True
            gc.collect()
            gc.freeze()  # what there is now stays: it need not be looked through again
            self.chair.forgets()

    def _lost(self) -> None:
        lost, self._thinking.lost = self._thinking.lost, ""
        if not lost:
            return
        self._outings.lost()
        self.chair.hold(Reason.NAVIGATOR_SILENT)
        self._note("chair", "navigator_lost", why=lost)
        if self._thinking.hopeless:
            self.trouble = "the navigator does not start; see the log"
            self._tell(Notice(code="broken", text="I cannot think, and so I stand."), None)
            return
        text = "I stopped thinking. I begin anew."
        owed, hearing = self._thinking.owed, self._hearing
        if owed is not None and owed.errand != self.chair.answered:  # nor would the next one
            hearing.errand = hearing.errand.to(None).without(None, every=True)
            text = "What you asked for was too much for me. I begin anew without it."
        self._tell(Notice(code="navigator_lost", text=text), None)

    def _world(self) -> None:
        try:
            made = self._playing.made()
        except CohelmError as trouble:
            _log.error("no world: %s", trouble)
            self.chair.waits = False
            self.trouble = "" if self.chair.play is not None else str(trouble)
            self._tell(Notice(code=trouble.code, text=str(trouble)), None)
            return
        if made is None:
            return
        again = self.chair.play is not None
        self.chair.put(made)
        if again:
            text = f"The simulation has begun anew, with seed {made.stage.seed}."
            self._note("chair", "restarted", seed=made.stage.seed)
            self._tell(Notice(code="restarted", text=text), None)


class LoopEffects:
    """What pages ask of the loop; see ``hearing.Effects``.

    Args:
        outings: keep ratings.
    """

    def __init__(self, outings: Outings) -> None:
        self._outings = outings
        self.loop: Loop
        self.pricing: Pricing

    def simulate(self, asked: Simulate) -> None:
        """What only a simulation can.

        Raises:
            CohelmError: why not.
        """
        chair = self.loop.chair
        if asked.what == "restart":
            self.loop.begin_anew(asked.seed)
            return
        if chair.play is None:
            raise NotNow("I am getting ready.")
        if asked.what == "pause":
            chair.pause(on=asked.on)
            return
        way = chair.view.way
        points = np.array(way.points if way is not None else ()).reshape(-1, 2)
        chair.play.do(asked, points)

    def preview(self, client: str, want: Want) -> None:
        """The price of a wish comes later."""
        self.pricing.ask(client, want)

    def rate(self, ride: str, rating: int) -> None:
        """How a ride was.

        Raises:
            StoreError: if there is no such ride.
        """
        self._outings.rate(ride, rating)
