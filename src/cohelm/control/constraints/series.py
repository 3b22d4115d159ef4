"""What every barrier on people shares: one series of h for each person and hypothesis."""

from __future__ import annotations

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Rows
from cohelm.control.constraints import barrier


def by_person(problem: LocalProblem, h: Floats, gamma: float) -> tuple[Floats, float]:
    """(the worst violation of each person's rows, (n,); the smallest h), from h (n·h, N+1)."""
    worst, smallest = barrier.worst(h, gamma)
    return worst.reshape(problem.predictions.mean.shape[:2]).max(axis=1), smallest


def person_rows(
    problem: LocalProblem, h: Floats, gradient: Floats, sensitivity: Floats, gamma: float
) -> Rows:
    """The rows that can become active, one slack for each person.

    h: (n·h, N+1).  gradient: (n·h, N+1, 3) of h in the pose.  sensitivity: (N+1, 3, N·m).
    """
    margin, jacobian, series, key = barrier.rows(h, gradient, sensitivity, gamma, barrier.NEAR)
    people, hypotheses = problem.predictions.mean.shape[:2]
    return Rows(
        margin=margin,
        jacobian=jacobian,
        group=series // hypotheses,
        key=key,
        keys=h[:, 1:].size,
        groups=people,
    )


def flattened(array: Floats) -> Floats:
    """(n, h, ...) as (n·h, ...): each person's hypotheses one after the other."""
    n, h = array.shape[:2]
    return array.reshape(n * h, *array.shape[2:])
