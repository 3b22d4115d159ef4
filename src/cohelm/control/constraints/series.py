"""What every barrier on people shares: one series of h for each person and hypothesis."""

from __future__ import annotations

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Measure, Rows
from cohelm.control.constraints import barrier


def by_person(problem: LocalProblem, h: Floats, gradient: Floats, gamma: float) -> Measure:
    """One slack for each person: the worst of his hypotheses and steps; from h (n·h, N+1)."""
    worst, smallest = barrier.worst(h, gamma)
    slack = worst.reshape(problem.predictions.mean.shape[:2]).max(axis=1)
    return Measure(slack=slack, smallest=smallest, h=h, gradient=gradient)


def person_rows(problem: LocalProblem, measure: Measure, sensitivity: Floats, gamma: float) -> Rows:
    """The rows that can become active, one slack for each person.

    measure: of series (n·h).  sensitivity: (N+1, 3, N·m).
    """
    h, gradient = measure.h, measure.gradient
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
