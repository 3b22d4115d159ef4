"""Memory of the planner: the homotopy class that its last plan committed to.

A trajectory that passes people, or the path, on other sides than the last plan has a switching
cost, in seconds of lost time. Otherwise the robot would alternate between two equal trajectories.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.api import LocalProblem
from cohelm.messages import LocalPlan, People
from cohelm.robots.contact import WALKING, touching

_EXPIRED = 1.0
"""A memory older than this is ignored, s."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannerMemory:
    """Facts about the last plan that the next one needs; a record of the inner loop.

    ``path_side`` and ``person_sides`` are a row of ``CandidateTrajectories.passing_sides``.
    """

    time: float
    """Time of the plan, s."""
    path_side: int
    """Side of the path."""
    person_id: Annotated[Integers, Shape("n")]
    """Identities of the people."""
    person_sides: Annotated[Integers, Shape("n")]
    """Side of each person."""
    tail: Annotated[Floats, Shape("L m")]
    """Inputs that continue the plan beyond its last step."""
    last_contact: float = -np.inf
    """Time when a walking person last touched the robot, s."""
    lowest_cost: float = -np.inf
    """Lowest trajectory cost of the plan since candidates were last sampled, s."""


def unexpired_memory(previous: LocalPlan | None, time: float) -> PlannerMemory | None:
    """The memory in the last plan; None if there is none, or it has expired."""
    memory = previous.memory if previous is not None else None
    if not isinstance(memory, PlannerMemory) or not 0.0 <= time - memory.time <= _EXPIRED:
        return None
    return memory


def class_changes(
    passing_sides: Integers, people: People, memory: PlannerMemory | None
) -> Integers:
    """Number of sides opposite to those of the last plan, (k,), for each trajectory (k, 1 + n).

    People who were not passed then, or are not passed now, do not count.
    """
    if memory is None:
        return np.zeros(len(passing_sides), dtype=np.int64)
    if memory.person_id is people.id or np.array_equal(memory.person_id, people.id):
        return _opposed(passing_sides, memory.path_side, memory.person_sides)
    # sides of the present people, by identity
    sides = np.zeros(len(people), dtype=np.int64)
    if len(memory.person_id) and len(people):
        order = np.argsort(memory.person_id, kind="stable")
        position = np.searchsorted(memory.person_id, people.id, sorter=order)
        match = order[np.minimum(position, len(order) - 1)]
        sides = np.where(memory.person_id[match] == people.id, memory.person_sides[match], 0)
    return _opposed(passing_sides, memory.path_side, sides)


@njit(cache=True)
def _opposed(passing_sides: Integers, path_side: int, person_sides: Integers) -> Integers:
    """Number of entries of each row (k, 1 + n) opposite to (path side, sides (n,)), (k,)."""
    out = np.zeros(passing_sides.shape[0], np.int64)
    for k in range(passing_sides.shape[0]):
        out[k] = passing_sides[k, 0] * path_side == -1
        for i in range(person_sides.shape[0]):
            out[k] += passing_sides[k, 1 + i] * person_sides[i] == -1
    return out


def last_contact(problem: LocalProblem, memory: PlannerMemory | None) -> float:
    """Time when a walking person last touched the robot, s; the present while it lasts."""
    walks = np.hypot(problem.people.mean[:, 2], problem.people.mean[:, 3]) > WALKING
    if (touching(problem.robot, problem.pose, problem.people) & walks).any():
        return problem.time
    return memory.last_contact if memory is not None else -np.inf
