"""What pages say, put into effect: who drives, where to, which way, how fast.

Everything here happens in the chair's thread, between two of its steps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from cohelm.driving import link
from cohelm.driving.audit import What
from cohelm.driving.limits import InForce
from cohelm.driving.messages import (
    Beat,
    Done,
    Floor,
    FromPage,
    Go,
    Notice,
    Rate,
    Refused,
    Release,
    Resume,
    Role,
    SetMode,
    SetPace,
    Simulate,
    Stop,
    Take,
    ToPage,
    Unwant,
    Want,
)
from cohelm.driving.wanted import MOST_WISHES, Errand, check_wish, goal_of, wish_of
from cohelm.errors import CohelmError
from cohelm.maps import Places
from cohelm.reasons import Reason

Tell = Callable[[ToPage, str | None], None]


class Note(Protocol):
    """Puts something into the audit log."""

    def __call__(self, who: str, what: What, **said: Any) -> None:
        """See ``audit.Audit.note``."""
        ...


class Effects(Protocol):
    """What only the chair itself can do; a CohelmError is why not."""

    def simulate(self, message: Simulate) -> None:
        """What only a simulation can."""
        ...

    def preview(self, client: str, want: Want) -> None:
        """Ask for the price of a wish; the answer comes later."""
        ...

    def rate(self, ride: str, rating: int) -> None:
        """Keep how a ride was."""
        ...


class Forbidden(CohelmError):
    """Only who drives may ask for that."""

    code = "not_driver"


class TooMany(CohelmError):
    """There are as many wishes as are heeded at once."""

    code = Reason.TOO_MANY_WISHES.value


class Hearing:
    """Link and errand, and what becomes of them by what pages say.

    Args:
        places: that can be named.
        in_force: limits and the rider's settings.
        tell: answers.
        note: the audit log.
        effects: of the chair.
        floor: beyond which no wish reaches; None: they reach anywhere.
    """

    def __init__(
        self,
        places: Places,
        in_force: InForce,
        tell: Tell,
        note: Note,
        effects: Effects,
        floor: Floor | None = None,
    ) -> None:
        self._floor = floor
        self.link = link.LinkState()
        self.errand = Errand()
        self._places, self._in_force = places, in_force
        self._tell, self._note, self._effects = tell, note, effects
        self._wishes = 0
        self._does: Mapping[type, Callable[[str, Any, float], None]] = {
            Beat: self._beat,
            Take: self._take,
            Release: self._release,
            Stop: self._stop,
            Resume: self._resume,
        }
        self._answers: Mapping[type, Callable[[str, Any], bool]] = {
            Go: self._go,
            Want: self._want,
            Unwant: self._unwant,
            SetMode: self._set_mode,
            SetPace: self._set_pace,
            Rate: self._rate,
            Simulate: self._simulate,
        }

    def joined(self, client: str, role: Role) -> None:
        """A page has come."""
        self._note(client, "joined", role=role)

    def left(self, client: str) -> None:
        """A page has gone; where it drove, nobody does now."""
        if client == self.link.driver:
            self._note(client, "released", why="left")
        self.link = link.left(self.link, client)
        self._note(client, "left")

    def heard(self, client: str, message: FromPage, at: float) -> None:
        """A page said something at ``at``, s; what has a number is answered."""
        does = self._does.get(type(message))
        if does is not None:
            does(client, message, at)
            return
        answers = self._answers.get(type(message))
        if answers is None:
            return
        number: int = message.id  # type: ignore[union-attr]  # all that are answered have one
        try:
            if answers(client, message):
                self._tell(Done(id=number), client)
        except CohelmError as refusal:
            self._refuse(client, number, refusal)

    def _refuse(self, client: str, number: int, refusal: CohelmError) -> None:
        problem = getattr(refusal, "problem", None)
        self._tell(Refused(id=number, code=refusal.code, text=problem or str(refusal)), client)

    def _beat(self, client: str, beat: Beat, at: float) -> None:
        dead_zone = self._in_force.rider.dead_zone
        self.link = link.beaten(self.link, client, beat, at, dead_zone=dead_zone)

    def _take(self, client: str, _: Take, __: float) -> None:
        before = self.link.driver
        if before == client:
            return
        self.link = link.took(self.link, client, under_way=self.errand.under_way)
        self._note(client, "took", before=before)
        if before is not None:
            self._tell(Notice(code="taken", text="Somebody else drives now."), before)
            self._tell(Notice(code="took", text="You drive now, instead of somebody else."), client)

    def _release(self, client: str, _: Release, __: float) -> None:
        if client == self.link.driver:
            self.link = link.released(self.link, client)
            self._note(client, "released")

    def _stop(self, client: str, _: Stop, __: float) -> None:
        before = self.link
        self.link = link.held(before, Reason.RIDER_STOP)
        if not (before.need is link.Need.CONFIRM and before.cause is Reason.RIDER_STOP):
            self._note(client, "stop")  # and not at every time that a page repeats it

    def _resume(self, client: str, _: Resume, at: float) -> None:
        after = link.resumed(self.link, client, at)
        if after is not self.link:
            self.link = after
            self._note(client, "resume")
            return
        found = link.status(self.link, at)
        if client != self.link.driver:
            self._refuse(client, 0, Forbidden("Only who drives can say to go on."))
        elif found in {"stopped", "centre"}:
            self._tell(Refused(code="let_go", text=Reason.LET_GO.sentence), client)

    def _drives(self, client: str) -> None:
        """Whoever drives decides; while nobody does, anybody may."""
        if self.link.driver not in {None, client}:
            raise Forbidden("Somebody else drives; take the stick first.")

    def _go(self, client: str, go: Go) -> bool:
        self._drives(client)
        goal = goal_of(go.place, go.point, self._places)
        self.errand = self.errand.to(goal)
        said = None if goal is None else goal.name or [round(goal.x, 2), round(goal.y, 2)]
        self._note(client, "goal", goal=said)
        return True

    def _want(self, client: str, want: Want) -> bool:
        if self._floor is not None:
            check_wish(want, self._floor)
        if want.preview:
            wish_of(want, 0)
            self._effects.preview(client, want)
            return False
        self._drives(client)
        if len(self.errand.wishes) >= MOST_WISHES:
            raise TooMany(Reason.TOO_MANY_WISHES.sentence)
        wish = wish_of(want, self._wishes + 1)
        self._wishes += 1
        self.errand = self.errand.wishing(wish)
        return True

    def _unwant(self, client: str, unwant: Unwant) -> bool:
        self._drives(client)
        self.errand = self.errand.without(unwant.wish, every=unwant.all)
        return True

    def _set_mode(self, client: str, asked: SetMode) -> bool:
        self._drives(client)
        self.errand = self.errand.steered(asked.mode)
        self._note(client, "mode", mode=asked.mode.value)
        return True

    def _set_pace(self, client: str, asked: SetPace) -> bool:
        self._drives(client)
        self.errand = self.errand.paced(asked.pace)
        self._note(client, "pace", pace=asked.pace)
        return True

    def _rate(self, _: str, rate: Rate) -> bool:
        self._effects.rate(rate.ride, rate.rating)
        return True

    def _simulate(self, client: str, asked: Simulate) -> bool:
        self._drives(client)
        self._effects.simulate(asked)
        self._note(client, "simulated", said=asked.what)
        return True
