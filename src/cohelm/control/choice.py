"""Which of several ways is taken: the cheapest by one score, where leaving the last way costs.

Scores are seconds of time lost (see ``candidates``). A way that passes people, or leads round the
path, on other sides than the last plan did has to be better by a margin, else a robot between two
equal ways would dither.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.api import LocalProblem
from cohelm.messages import LocalPlan, People
from cohelm.robots.contact import WALKING, touching

_FORGOTTEN = 1.0
"""A way taken longer ago than this is no memory, s."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WayTaken:
    """How the last plan passed everybody: the planner's memory, a record of the inner loop."""

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
    if memory.id is people.id or np.array_equal(memory.id, people.id):
        return _opposed(signature, memory.side, memory.turn)
    last = np.zeros(1 + len(people), dtype=np.int64)
    last[0] = memory.side
    if len(memory.id) and len(people):
        order = np.argsort(memory.id, kind="stable")
        at = order[np.minimum(np.searchsorted(memory.id, people.id, sorter=order), len(order) - 1)]
        last[1:] = np.where(memory.id[at] == people.id, memory.turn[at], 0)
    return _opposed(signature, int(last[0]), last[1:])


@njit(cache=True)
def _opposed(signature: Integers, side: int, turn: Integers) -> Integers:
    """In how many places each way (k, 1 + n) has the opposite of (side, turn (n,)), (k,)."""
    out = np.zeros(signature.shape[0], np.int64)
    for k in range(signature.shape[0]):
        out[k] = signature[k, 0] * side == -1
        for i in range(turn.shape[0]):
            out[k] += signature[k, 1 + i] * turn[i] == -1
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
