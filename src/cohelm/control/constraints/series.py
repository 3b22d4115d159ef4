"""What barriers share: series of h over the horizon, by discs, groups, or people's hypotheses."""

from __future__ import annotations

from dataclasses import replace

from cohelm.arrays import Floats
from cohelm.control.api import LocalProblem, Measure, Rows
from cohelm.control.constraints import barrier


def by_person(problem: LocalProblem, h: Floats, gradient: Floats, gamma: float) -> Measure:
    """One slack for each person: the worst of his hypotheses and steps; from h (n·h, N+1)."""
    worst, smallest = barrier.worst(h, gamma)
    slack = worst.reshape(problem.predictions.mean.shape[:2]).max(axis=1)
    return Measure(slack=slack, smallest=smallest, h=h, gradient=gradient)


def series_rows(
    h: Floats, gradient: Floats, sensitivity: Floats, gamma: float, near: float
) -> Rows:
    """The rows that can become active, one slack for each series; see ``barrier.rows``."""
    margin, jacobian, series, key = barrier.rows(h, gradient, sensitivity, gamma, near)
    return Rows(
        margin=margin,
        jacobian=jacobian,
        group=series,
        key=key,
        keys=h[:, 1:].size,
        groups=len(h),
    )


def person_rows(problem: LocalProblem, measure: Measure, sensitivity: Floats, gamma: float) -> Rows:
    """The rows that can become active, one slack for each person.

    measure: of series (n·h).  sensitivity: (N+1, 3, N·m).
    """
    people, hypotheses = problem.predictions.mean.shape[:2]
    rows = series_rows(measure.h, measure.gradient, sensitivity, gamma, barrier.NEAR)
    return replace(rows, group=rows.group // hypotheses, groups=people)


def flattened(array: Floats) -> Floats:
    """(n, h, ...) as (n·h, ...): each person's hypotheses one after the other."""
    n, h = array.shape[:2]
    return array.reshape(n * h, *array.shape[2:])
