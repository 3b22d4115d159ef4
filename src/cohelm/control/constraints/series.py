"""What barriers share that give each series of h a slack of its own: discs, groups, people."""

from __future__ import annotations

from cohelm.arrays import Floats
from cohelm.control.api import Rows
from cohelm.control.constraints import barrier


def series_rows(
    h: Floats, gradient: Floats, sensitivity: Floats, gamma: float, near: float
) -> Rows:
    """The rows that can become active, one slack for each series; see ``barrier.rows``.

    h: (s, N+1) m.  gradient: (s, N+1, 3) of h in the pose.  sensitivity: (N+1, 3, N·m).
    """
    margin, jacobian, series, key = barrier.rows(h, gradient, sensitivity, gamma, near)
    return Rows(
        margin=margin,
        jacobian=jacobian,
        group=series,
        key=key,
        keys=h[:, 1:].size,
        groups=len(h),
    )
