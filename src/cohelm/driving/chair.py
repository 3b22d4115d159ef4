"""The chair's own thread: 20 times a second from what is known to the wheels, whoever fails.

t       what pages said; the beat that counts now goes into the observation, and that to the
        navigator
…       its answer, waited for as long as the step has room
t + c   what goes to the wheels: the answer, or zero where link, watchdog or anything else
        holds the chair; pages are told; the world goes a step on
t + T   again
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cohelm.driving import link
from cohelm.driving.asking import Answer, Ask
from cohelm.driving.crew import Crew
from cohelm.driving.hearing import Hearing, Tell
from cohelm.driving.limits import InForce
from cohelm.driving.messages import Notice
from cohelm.driving.playing import Play
from cohelm.driving.saying import View, state_of
from cohelm.driving.wanted import request_of
from cohelm.driving.wheels import FORGETFUL, PATIENCE, Watch, gently
from cohelm.messages import Observation, PointCloud, RiderCommand, RiderProfile, Scan
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.simulation import is_standing

STEP = 0.05
"""From step to step, s."""
ROOM = 0.036
"""Of a step in which an answer is waited for, s; the rest is for the world."""
_MOST_UNSEEN = 8
"""Sweeps kept for a navigator that is late."""


class Chair:
    """The chair in its world, and who is asked about it. Belongs to one thread.

    Args:
        hearing: who drives, and what they want.
        in_force: limits and settings.
        profile: of the scenario's rider.
        crew: whoever works aside.
        tell: whoever listens.
        clock: s, steady.
    """

    def __init__(
        self,
        hearing: Hearing,
        in_force: InForce,
        profile: RiderProfile,
        crew: Crew,
        *,
        tell: Tell,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._hearing, self._in_force, self._profile = hearing, in_force, profile
        self._thinking, self._pricing, self._outings = crew.thinking, crew.pricing, crew.outings
        self._tell, self._clock = tell, clock
        self.play: Play | None = None
        self._gets_ready = True
        self.paused = False
        self.waits = False
        """Whether another world is being made; until then it stands."""
        self._afresh, self._since = False, 0
        self._watch = Watch()
        self.view = View()
        self._told_route = -1
        self.order = stop(Reason.GETTING_READY)
        """What is at the wheels."""
        self.preparing = ""
        """What to say besides while the chair gets ready."""
        self._heard, self._turn = -1, 0
        self._scans: tuple[Scan, ...] = ()
        self._clouds: tuple[PointCloud, ...] = ()
        self._touching = self.arrived = False
        self.ticks = 0
        self.answered = -1
        """``Errand.version`` that the navigator answered last; −1: none since it began."""
        self.stops = 0
        """How often the watchdog stopped it."""

    @property
    def moves(self) -> bool:
        """Whether the chair moves, or is told to."""
        if self.play is None:
            return False
        return bool(self.order.twist.any()) or not bool(is_standing(self.play.world.truth.twist))

    def put(self, play: Play) -> None:
        """Into another world, where it stands and has nowhere to go.

        What was chosen before there was any world is kept.
        """
        begins_anew = self.play is not None
        self.play, self.paused, self.waits = play, False, False
        self._afresh, self._since = True, self.ticks
        self._watch, self.view = Watch(), replace(View(), version=self.view.version + 1)
        self._scans, self._clouds = (), ()
        self._touching = self.arrived = False
        self.order = stop(Reason.GETTING_READY)
        hearing = self._hearing
        if begins_anew:
            hearing.errand = hearing.errand.to(None).without(None, every=True)
        hearing.link = link.recentred(hearing.link)
        self._outings.on(play.stage)

    def pause(self, *, on: bool) -> None:
        """Let time stand still, or go on; a stick that is held then does not count."""
        if self.paused and not on:
            self._hearing.link = link.recentred(self._hearing.link)
            self._watch = replace(self._watch, at=self._clock())
        self.paused = on

    def forgets(self) -> None:
        """The navigator began anew, and knows nothing of before."""
        self._afresh, self._watch, self.answered = True, Watch(), -1

    def step(self, due: float, attend: Callable[[], None]) -> None:
        """One step.

        Args:
            due: when it was to begin, s.
            attend: lets what pages said take effect; called once more before the wheels.
        """
        attend()
        late = max(self._clock() - due, 0.0)
        play = self.play
        if play is not None and self.paused:
            self._glance(play)
        elif play is not None:
            room = ROOM + (late if late >= STEP else 0.0)  # what is lost is lost
            self._ask(play, late)
            self._listen(play, due + room, late)
            attend()
        if play is not self.play:
            return  # begun anew in between
        now = self._clock()
        self._decide(now)
        self._tell_of(play, now, late)
        if play is not None and not self.paused:
            self._go_on(play)
        self.ticks += 1

    def _ask(self, play: Play, late: float) -> None:
        """Ask about the newest observation, if the navigator is free."""
        if not self._thinking.free:
            return
        now, hearing, seen = self._clock(), self._hearing, play.world.observe()
        ready = link.status(hearing.link, now) == "ready"
        marks = self._outings.marks()
        observation = replace(
            seen,
            scans=(*self._scans, *seen.scans),
            clouds=(*self._clouds, *seen.clouds),
            rider=self._hand(seen, now) if ready else None,
            late=late,
        )
        limits, rider = self._in_force.limits, self._in_force.rider
        asked = Ask(
            number=self.ticks,
            errand=hearing.errand.version,
            observation=observation,
            request=request_of(hearing.errand, self._profile, limits, rider, moves=ready),
            truth=play.world.truth,
            heard=link.heard(hearing.link, now)[0] if ready else -1,
            distance=max(limits.min_distance - self._profile.social_distance, 0.0),
            afresh=self._afresh,
            begin=marks.begin,
            end=marks.end,
            surroundings=self._pricing.wanted,
        )
        self._afresh = False
        self._scans, self._clouds = (), ()
        self._turn = hearing.link.turn
        self._thinking.ask(asked, now)

    def _glance(self, play: Play) -> None:
        """While time stands still, ask only about what a wish would be priced by."""
        now, hearing = self._clock(), self._hearing
        answer = self._thinking.answer(0.0, now)
        if answer is not None:
            self._take(play, answer)
        if not (self._pricing.wanted and self._thinking.free):
            return
        limits, rider = self._in_force.limits, self._in_force.rider
        asked = Ask(
            number=self.ticks,
            errand=hearing.errand.version,
            observation=play.world.observe(),
            request=request_of(hearing.errand, self._profile, limits, rider, moves=False),
            truth=play.world.truth,
            heard=-1,
            glance=True,
            surroundings=True,
        )
        self._thinking.ask(asked, now)

    def _listen(self, play: Play, until: float, late: float) -> None:
        """Take the answers that come before ``until``, s, till there is one of this step."""
        while self._thinking.asked is not None:
            now = self._clock()
            answer = self._thinking.answer(max(until - now, 0.0), now)
            if answer is None:
                break
            self._take(play, answer)
            if answer.number == self.ticks or self._clock() >= until:
                break
            self._ask(play, late)
        asked = self._thinking.asked
        if asked is not None and asked.number == self.ticks:
            return
        if asked is not None or not self._thinking.ready:
            seen = play.world.observe()
            self._scans = (*self._scans, *seen.scans)[-_MOST_UNSEEN:]
            self._clouds = (*self._clouds, *seen.clouds)[-_MOST_UNSEEN:]

    def _take(self, play: Play, answer: Answer) -> None:
        """Heed an answer; one to what is long past moves nothing any more."""
        hearing, now = self._hearing, self._clock()
        self._outings.logged(answer.log)
        if answer.number < self._since:
            return  # of a world that is gone
        if answer.surroundings is not None:
            self._pricing.surrounded(answer.surroundings)
        if answer.glance:
            return
        if now - self._thinking.asked_at <= PATIENCE:
            self._watch = self._watch.told(answer.decision, answer.heard, now, self._turn)
        self.answered = answer.errand
        self.view = self.view.shown(answer, hearing.errand)
        current = answer.errand == hearing.errand.version and hearing.errand.goal is not None
        if answer.arrived and current and bool(is_standing(play.world.truth.twist)):
            self._arrive()

    def _hand(self, seen: Observation, now: float) -> RiderCommand:
        """The rider's device as the navigator knows it, in the time of the ride."""
        age = max(now - self._hearing.link.at, 0.0)
        stick = np.array(link.deflection(self._hearing.link, now))
        return RiderCommand(heartbeat=seen.time - age, deflection=stick)

    def _decide(self, now: float) -> None:
        """What goes to the wheels in this step."""
        watch = self._watch
        if self.paused:
            self.order = stop(Reason.PAUSED)
            return
        self._begin_ready(self.waits or (watch.decision is None and self._thinking.begun <= 1))
        hold = link.why(self._hearing.link, now)
        if hold is None and watch.turn != self._hearing.link.turn:
            hold = Reason.LET_GO  # what was decided before somebody let go
        if self._gets_ready:
            hold = Reason.GETTING_READY
        elif watch.decision is None or now - watch.at > FORGETFUL:
            self.hold(Reason.NAVIGATOR_SILENT)
        wanted = watch.order(now, hold)
        self._heard = watch.heard if hold is None else link.heard(self._hearing.link, now)[0]
        if wanted.reason is Reason.NAVIGATOR_SILENT and self.order.twist.any():
            self.stops += 1
        before = self.order.twist
        self.order = gently(wanted, before, self._in_force.limits.max_acceleration, STEP)

    def _begin_ready(self, gets_ready: bool) -> None:
        """Who chose meanwhile where to go has not yet seen it ready: they say when."""
        hearing = self._hearing
        if self._gets_ready and not gets_ready and hearing.errand.under_way:
            hearing.link = link.confirming(hearing.link)
        self._gets_ready = gets_ready

    def _go_on(self, play: Play) -> None:
        """Let the world pass a step, and see what came of it."""
        hearing, world, before = self._hearing, play.world, play.world.truth
        world.advance(self.order)
        after = world.truth
        self.arrived &= not self.order.twist.any()
        self._outings.went(
            self.order,
            hearing.errand,
            way=float(np.hypot(*(after.pose[:2] - before.pose[:2]))),
            device=link.heard(hearing.link, self._clock())[1],
        )
        touches = bool(after.hit_moving.any()) or after.hit_wall
        if touches and not self._touching:
            self.hold(Reason.COLLISION)
            self._outings.end("collision")
            self._tell(Notice(code="collision", text=Reason.COLLISION.sentence), None)
        self._touching = touches
        if hearing.link.driver is None:
            self._outings.end("left")

    def _arrive(self) -> None:
        hearing = self._hearing
        goal = hearing.errand.goal
        text = f"We have arrived: {goal.name}." if goal and goal.name else Reason.ARRIVED.sentence
        hearing.errand = hearing.errand.to(None)
        hearing.link = link.recentred(hearing.link)
        self.arrived = True
        self._outings.end("arrived")
        self._tell(Notice(code="arrived", text=text), None)

    def hold(self, cause: Reason) -> None:
        """Stand until the driver confirms."""
        self._hearing.link = link.held(self._hearing.link, cause)

    def _tell_of(self, play: Play | None, now: float, late: float) -> None:
        if self.view.version != self._told_route:
            self._told_route = self.view.version
            self._tell(self.view.route(), None)
        state = state_of(
            play,
            self._hearing,
            self.view,
            self.order,
            preparing=self.preparing,
            now=now,
            seq=self.ticks,
            heard=self._heard,
            late=round(1000.0 * late, 1),
            clock=round(now, 4),
            arrived=self.arrived,
            paused=self.paused,
            ride=self._outings.ride,
        )
        self._tell(state, None)
