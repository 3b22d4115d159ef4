"""What a page is told of a step: the state, and the route where it is another one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.driving import link
from cohelm.driving.asking import Answer, Points, Way
from cohelm.driving.hearing import Hearing
from cohelm.driving.messages import Person, Route, State, Wanted, Why
from cohelm.driving.playing import Play
from cohelm.driving.wanted import Errand
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.simulation import Truth

_QUIET = frozenset({Reason.ARRIVED})
"""Reasons that hold nothing back."""
_NOWHERE: tuple[Any, ...] = ((0.0, 0.0, 0.0), np.zeros(3), 0.0, (), ())
"""Pose, twist, time, bodies and shut doors where there is no world yet."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What the navigator showed last; a page goes on showing it while nothing newer comes."""

    eta: float = 0.0
    remaining: float | None = None
    plan: tuple[tuple[float, float, float], ...] = ()
    people: tuple[Person, ...] = ()
    groups: tuple[Points, ...] = ()
    way: Way | None = None
    trouble: str = ""
    wishes: tuple[Wanted, ...] = ()
    version: int = 0
    """Of the route."""

    def shown(self, answer: Answer, errand: Errand) -> View:
        """With a new answer; the route's version grows where anything of it is otherwise."""
        way = answer.way if answer.way is not None else self.way
        wishes = errand.wishes if answer.errand == errand.version else self.wishes
        same = way == self.way and answer.trouble == self.trouble and wishes == self.wishes
        return replace(
            self,
            eta=answer.eta,
            remaining=answer.remaining,
            plan=answer.plan,
            people=tuple(_person(row) for row in answer.people),
            groups=answer.groups,
            way=way,
            trouble=answer.trouble,
            wishes=wishes,
            version=self.version if same else self.version + 1,
        )

    def route(self) -> Route:
        """The message that tells of it."""
        way = self.way
        found = Route(version=self.version, wishes=self.wishes, trouble=self.trouble)
        if way is None:
            return found
        return found.model_copy(
            update={
                "points": way.points,
                "without": way.without,
                "length": way.length,
                "extra": way.extra,
            }
        )


def state_of(
    play: Play | None,
    hearing: Hearing,
    view: View,
    order: Decision,
    *,
    preparing: str,
    now: float,
    **said: Any,
) -> State:
    """How things are.

    Args:
        play: the world; None: there is none yet.
        hearing: who drives, and what they want.
        view: what the navigator showed last.
        order: what is at the wheels.
        preparing: what to say besides while the chair gets ready.
        now: s of the chair's clock.
        said: further fields.
    """
    held, errand = hearing.link, hearing.errand
    status = link.status(held, now)
    pose, twist, time, bodies, shut = _NOWHERE
    if play is not None:
        seen, truth = play.world.observe(), play.world.truth
        pose, twist, time = rounded(seen.pose), seen.twist, truth.time
        bodies, shut = bodies_of(truth), tuple(sorted(play.world.shut))
    return State.model_construct(
        time=round(time, 3),
        pose=pose,
        speed=round(float(twist[0]), 3),
        turn=round(float(twist[2]), 3),
        command=(round(float(order.twist[0]), 4), round(float(order.twist[2]), 4)),
        driver=held.driver,
        device=link.heard(held, now)[1],
        link=status,
        mode=errand.mode,
        pace=errand.pace,
        eta=view.eta,
        why=why_of(order, preparing=preparing, asks=link.asks(status)),
        goal=errand.goal,
        remaining=view.remaining if errand.goal is not None else None,
        route=view.version,
        plan=view.plan,
        people=view.people,
        groups=view.groups,
        bodies=bodies,
        shut=shut,
        **said,
    )


def why_of(decision: Decision, *, preparing: str, asks: Reason | None) -> Why | None:
    """Why the chair does not do as wished, for the rider.

    Args:
        decision: at the wheels.
        preparing: what to say besides while the chair gets ready.
        asks: what the driver has to do first; None: nothing.
    """
    reason = decision.reason
    if reason is None or reason in _QUIET:
        return None
    text = reason.sentence
    if reason is Reason.GETTING_READY:
        text = f"{text} {preparing}".strip()
    elif asks is not None and asks is not reason:
        text = f"{text} {asks.sentence}"
    return Why.model_construct(code=reason.value, text=text)


def bodies_of(truth: Truth) -> tuple[tuple[float, float, float], ...]:
    """Everybody who is truly there, (x, y, radius), m."""
    crowd = truth.crowd
    rows = zip(crowd.position.tolist(), crowd.radius.tolist(), crowd.there.tolist(), strict=True)
    return tuple((round(x, 3), round(y, 3), radius) for (x, y), radius, there in rows if there)


def rounded(pose: Floats) -> tuple[float, float, float]:
    """To a millimetre and a milliradian."""
    x, y, heading = pose.tolist()
    return round(x, 3), round(y, 3), round(heading, 3)


def _person(row: tuple[float, ...]) -> Person:
    id_, x, y, vx, vy, radius, axis, front, side, rear, group = row
    return Person.model_construct(
        id=int(id_), x=x, y=y, vx=vx, vy=vy, radius=radius,
        axis=axis, front=front, side=side, rear=rear, group=int(group),
    )  # fmt: skip
