"""Commitment to a homotopy class: switching to another one has a cost.

Scores are seconds of lost time (see ``sampling``). A trajectory that passes people, or the path, on
other sides than the last plan must be better by a margin. Otherwise the robot would alternate
between two equal trajectories.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.sqp import MotionValue
from cohelm.messages import LocalPlan, People
from cohelm.robots.contact import WALKING, touching

_EXPIRED = 1.0
"""A commitment older than this is ignored, s."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommittedClass:
    """Homotopy class of the last plan: the planner's memory, a record of the inner loop."""

    time: float
    """Time of the plan, s."""
    side: int
    """Side of the path, as in ``CandidateTrajectories.homotopy``."""
    id: Annotated[Integers, Shape("n")]
    """Identities of the people."""
    turn: Annotated[Integers, Shape("n")]
    """Turn of the bearing to each, as in ``CandidateTrajectories.homotopy``."""
    tail: Annotated[Floats, Shape("L m")]
    """Inputs that continue the plan."""
    last_contact: float = -np.inf
    """Time when a walking person last touched the robot, s."""
    score: float = -np.inf
    """Lowest cost of the plan since candidates were last sampled, s."""


class EvaluatedCandidate(NamedTuple):
    """A trajectory that may be used."""

    name: str
    motion: Motion
    tail: Floats
    """(L, m) inputs that continue the motion."""
    score: float
    """s, costs of switching and exploration included."""
    own_score: float
    """s, without these."""
    homotopy: Integers
    value: MotionValue | None = None
    """Result of the SQP at the motion; its costs are those of polishing."""


def previous_commitment(previous: LocalPlan | None, time: float) -> CommittedClass | None:
    """The commitment of the last plan, unless it has expired."""
    memory = previous.memory if previous is not None else None
    if not isinstance(memory, CommittedClass) or not 0.0 <= time - memory.time <= _EXPIRED:
        return None
    return memory


def class_changes(homotopy: Integers, people: People, memory: CommittedClass | None) -> Integers:
    """Number of opposite sides of each trajectory (k, 1 + n) compared with the last plan, (k,).

    People who were not passed then, or are not passed now, do not count.
    """
    if memory is None:
        return np.zeros(len(homotopy), dtype=np.int64)
    if memory.id is people.id or np.array_equal(memory.id, people.id):
        return _opposed(homotopy, memory.side, memory.turn)
    turn = np.zeros(len(people), dtype=np.int64)
    if len(memory.id) and len(people):
        order = np.argsort(memory.id, kind="stable")
        at = order[np.minimum(np.searchsorted(memory.id, people.id, sorter=order), len(order) - 1)]
        turn = np.where(memory.id[at] == people.id, memory.turn[at], 0)
    return _opposed(homotopy, memory.side, turn)


@njit(cache=True)
def _opposed(homotopy: Integers, side: int, turn: Integers) -> Integers:
    """Number of entries of each row (k, 1 + n) opposite to (side, turn (n,)), (k,)."""
    out = np.zeros(homotopy.shape[0], np.int64)
    for k in range(homotopy.shape[0]):
        out[k] = homotopy[k, 0] * side == -1
        for i in range(turn.shape[0]):
            out[k] += homotopy[k, 1 + i] * turn[i] == -1
    return out


def last_contact(problem: LocalProblem, memory: CommittedClass | None) -> float:
    """Time when a walking person last touched the robot, s; now while it lasts."""
    walks = np.hypot(problem.people.mean[:, 2], problem.people.mean[:, 3]) > WALKING
    if (touching(problem.robot, problem.pose, problem.people) & walks).any():
        return problem.time
    return memory.last_contact if memory is not None else -np.inf
