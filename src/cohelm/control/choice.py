"""Which of several ways is taken: the cheapest by one score, where leaving the last way costs.

Scores are seconds of time lost (see ``candidates``). A way that passes people, or leads round the
path, on other sides than the last plan did has to be better by a margin, else a robot between two
equal ways would dither.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.control.api import LocalProblem
from cohelm.messages import LocalPlan, People
from cohelm.robots.contact import WALKING, touching

_FORGOTTEN = 1.0
"""A way taken longer ago than this is no memory, s."""


@value
class WayTaken:
    """How the last plan passed everybody: the planner's memory."""

    time: float
    """When it was made, s."""
    side: int
    """Of the path on which it led, as in ``Ways.signature``."""
    id: Annotated[Integers, Shape("n")]
    """Of the people."""
    turn: Annotated[Integers, Shape("n")]
    """How the bearing to each turns, as in ``Ways.signature``."""
    beyond: Annotated[Floats, Shape("L m")]
    """Inputs with which the way goes on after the plan."""
    touched: float = -np.inf
    """When somebody who walks was last seen to touch the robot, s."""
    score: float = -np.inf
    """The least that the way was found to cost since ways were last sampled, s."""


def remembered(previous: LocalPlan | None, time: float) -> WayTaken | None:
    """What the last plan left, where it is not too old."""
    memory = previous.memory if previous is not None else None
    if not isinstance(memory, WayTaken) or not 0.0 <= time - memory.time <= _FORGOTTEN:
        return None
    return memory


def departures(signature: Integers, people: People, memory: WayTaken | None) -> Integers:
    """In how many regards each way (k, 1 + n) passes otherwise than the last plan did, (k,).

    Who was not passed then, or is not passed now, is not counted.
    """
    if memory is None:
        return np.zeros(len(signature), dtype=np.int64)
    last = np.zeros(1 + len(people), dtype=np.int64)
    last[0] = memory.side
    if len(memory.id) and len(people):
        order = np.argsort(memory.id, kind="stable")
        at = order[np.minimum(np.searchsorted(memory.id, people.id, sorter=order), len(order) - 1)]
        last[1:] = np.where(memory.id[at] == people.id, memory.turn[at], 0)
    out: Integers = (signature * last == -1).sum(axis=1)
    return out


def taken(
    time: float,
    signature: Integers,
    people: People,
    *,
    beyond: Floats,
    touched: float,
    score: float,
) -> WayTaken:
    """The record of a way with ``signature`` (1 + n,)."""
    return WayTaken(
        time=time,
        side=int(signature[0]),
        id=people.id,
        turn=signature[1:],
        beyond=beyond,
        touched=touched,
        score=score,
    )


def last_touched(problem: LocalProblem, memory: WayTaken | None) -> float:
    """When somebody who walks last touched the robot, s; while he stays, he counts as walking."""
    last = memory.touched if memory is not None else -np.inf
    walks = np.hypot(problem.people.mean[:, 2], problem.people.mean[:, 3]) > WALKING
    return (
        problem.time
        if (touching(problem.robot, problem.pose, problem.people) & walks).any()
        else last
    )
