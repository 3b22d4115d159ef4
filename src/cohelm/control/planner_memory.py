"""Memory of the planner: the homotopy class that its last plan committed to.

A trajectory that passes people, or the path, on other sides than the last plan has a switching
cost, in seconds of lost time. Otherwise the robot would alternate between two equal trajectories.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.control.trajectories import TICK
from cohelm.kernels import CACHED
from cohelm.messages import LocalPlan, People

AnyArray = NDArray[Any]
_LATELY = 1.0
"""Time constant with which the recent speed of a person fades, s."""
_HELD_UP = 10.0
"""Time constant with which the pace of a person fades, s: about as long as a crowd may be held up;
assumed."""
_SAME_TIME = 1e-6
"""Difference of times that is rounding, s."""
_ONE_COMMAND = 2.0 * TICK + _SAME_TIME
"""Time up to which only one command has been sent since the last plan, s."""
EXPIRED = 1.0
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
    person_speeds: Annotated[Floats, Shape("n")]
    """Recent speed of each person, m/s, see :func:`recent_speeds`."""
    person_paces: Annotated[Floats, Shape("n")]
    """Pace of each person, m/s, see :func:`recent_paces`."""
    person_courses: Annotated[Floats, Shape("n")]
    """Time for which each person has been on a course into the robot, s, see ``unaware``."""
    tail: Annotated[Floats, Shape("L m")]
    """Inputs that continue the plan beyond its last step."""
    input_time: float
    """Time of the last plan or stop, s."""
    current_input: Annotated[Floats, Shape("m")]
    """u_{−1} at that time."""
    stands_since: float = np.inf
    """Time when the robot came to a stand, s; +inf: it moves, or has not moved before."""
    lowest_cost: float = -np.inf
    """Lowest trajectory cost of the plan since candidates were last sampled, s."""


def unexpired_memory(previous: LocalPlan | None, time: float) -> PlannerMemory | None:
    """The memory in the last plan; None if there is none, or it has expired."""
    memory = previous.memory if previous is not None else None
    if not isinstance(memory, PlannerMemory) or not 0.0 <= time - memory.input_time <= EXPIRED:
        return None
    return memory


def present_acceleration(memory: PlannerMemory | None, time: float, current_input: Floats) -> float:
    """Linear acceleration since the last plan, m/s²; 0 without one.

    A command changes the input by what fits into a tick. If the next one comes a little later, as
    with a slow scanner, that is still one tick's change: averaged over the time that has passed, it
    would let a chair with a limit of jerk hardly gather speed.
    """
    elapsed = 0.0 if memory is None else time - memory.input_time
    if memory is None or elapsed < _SAME_TIME:
        return 0.0
    if abs(elapsed - TICK) > _SAME_TIME and elapsed < _ONE_COMMAND:
        elapsed = TICK
    return float(current_input[0] - memory.current_input[0]) / elapsed


def class_changes(
    passing_sides: Integers, people: People, memory: PlannerMemory | None
) -> Integers:
    """Number of sides opposite to those of the last plan, (k,), for each trajectory (k, 1 + n).

    People who were not passed then, or are not passed now, do not count.
    """
    if memory is None:
        return np.zeros(len(passing_sides), dtype=np.int64)
    sides = remembered(memory, people, memory.person_sides)
    return _opposed(passing_sides, memory.path_side, sides)


def recent_speeds(people: People, memory: PlannerMemory | None, time: float) -> Floats:
    """Highest recent speed of each person, (n,), m/s; it fades while the person is slower.

    A person who turns back is measured as slow, like one who stands; only this distinguishes them.
    """
    before = None if memory is None else memory.person_speeds
    return _faded(people, memory, time, before, _LATELY)


def recent_paces(people: People, memory: PlannerMemory | None, time: float) -> Floats:
    """Pace of each person, (n,), m/s: the highest speed, which fades over 10 s.

    People who are held up in a crowd keep the pace of walking people for some time.
    """
    before = None if memory is None else memory.person_paces
    return _faded(people, memory, time, before, _HELD_UP)


def _faded(
    people: People, memory: PlannerMemory | None, time: float, before: Floats | None, fading: float
) -> Floats:
    """Present speeds (n,), or those before that have faded, if they are higher, m/s."""
    speeds = np.hypot(people.mean[:, 2], people.mean[:, 3])
    if memory is None or before is None:
        return speeds
    faded = math.exp(-max(time - memory.input_time, 0.0) / fading)
    return np.maximum(speeds, faded * remembered(memory, people, before))


def remembered(memory: PlannerMemory, people: People, values: AnyArray) -> AnyArray:
    """Remembered values of the present people, by identity; 0 for those who are new."""
    if memory.person_id.tobytes() == people.id.tobytes():
        return values
    out = np.zeros(len(people), dtype=values.dtype)
    if len(memory.person_id) and len(people):
        order = np.argsort(memory.person_id, kind="stable")
        position = np.searchsorted(memory.person_id, people.id, sorter=order)
        match = order[np.minimum(position, len(order) - 1)]
        out = np.where(memory.person_id[match] == people.id, values[match], 0)
    return out


@njit(**CACHED)
def _opposed(passing_sides: Integers, path_side: int, person_sides: Integers) -> Integers:
    """Number of entries of each row (k, 1 + n) opposite to (path side, sides (n,)), (k,)."""
    out = np.zeros(passing_sides.shape[0], np.int64)
    for k in range(passing_sides.shape[0]):
        out[k] = passing_sides[k, 0] * path_side == -1
        for i in range(person_sides.shape[0]):
            out[k] += passing_sides[k, 1 + i] * person_sides[i] == -1
    return out
