"""What barriers share that give each series of h a slack of its own: discs, groups, people."""

from __future__ import annotations

from cohelm.arrays import Floats, Integers
from cohelm.control.api import Rows
from cohelm.control.constraints import barrier


def series_rows(
    h: Floats, gradient: Floats, sensitivity: Floats, gamma: float, near: float
) -> Rows:
    """The rows that can become active, one slack for each series; see ``barrier.rows``.

    h: (s, N+1) m.  gradient: (s, N+1, 3) of h in the pose.  sensitivity: (N+1, 3, N·m).
    """
    return as_series(h, *barrier.rows(h, gradient, sensitivity, gamma, near))


def as_series(h: Floats, margin: Floats, jacobian: Floats, series: Integers, key: Integers) -> Rows:
    """What ``barrier.rows`` found of h (s, N+1), one slack for each series."""
    count, states = h.shape
    return Rows(margin, jacobian, series, key, count * (states - 1), groups=count)
