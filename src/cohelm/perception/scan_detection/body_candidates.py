"""Candidates for people in one scan."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.kernels import callee


class Body(NamedTuple):
    """One candidate; map frame."""

    x: float
    """Centre of the disc, m."""
    y: float
    """Centre of the disc, m."""
    radius: float
    """m."""
    deviation: float
    """Standard deviation of the centre, m."""
    log_odds: float
    """ln(p / (1 − p)) of a person."""
    mean_x: float
    """Mean of the visible returns, m."""
    mean_y: float
    """Mean of the visible returns, m."""


class BodyCandidates(NamedTuple):
    """Candidates of a scan, d of them; see :class:`Body`."""

    disc_centre: Floats
    """(d, 2) m."""
    radius: Floats
    """(d,) m."""
    deviation: Floats
    """(d,) m."""
    log_odds: Floats
    """(d,)."""
    mean: Floats
    """(d, 2) m."""


@callee()
def empty_candidates(d: int) -> BodyCandidates:
    """Uninitialised rows for ``d`` candidates."""
    return BodyCandidates(np.empty((d, 2)), np.empty(d), np.empty(d), np.empty(d), np.empty((d, 2)))


@callee()
def store(rows: BodyCandidates, k: int, body: Body) -> None:
    """Write a body into row ``k``, in place."""
    rows.disc_centre[k, 0], rows.disc_centre[k, 1] = body.x, body.y
    rows.radius[k], rows.deviation[k] = body.radius, body.deviation
    rows.log_odds[k] = body.log_odds
    rows.mean[k, 0], rows.mean[k, 1] = body.mean_x, body.mean_y


@callee()
def first_rows(rows: BodyCandidates, count: int) -> BodyCandidates:
    """View of the first ``count`` rows."""
    return BodyCandidates(
        rows.disc_centre[:count],
        rows.radius[:count],
        rows.deviation[:count],
        rows.log_odds[:count],
        rows.mean[:count],
    )


@callee()
def join(a: BodyCandidates, b: BodyCandidates) -> BodyCandidates:
    """Rows of ``a``, then those of ``b``."""
    return BodyCandidates(
        np.concatenate((a.disc_centre, b.disc_centre)),
        np.concatenate((a.radius, b.radius)),
        np.concatenate((a.deviation, b.deviation)),
        np.concatenate((a.log_odds, b.log_odds)),
        np.concatenate((a.mean, b.mean)),
    )
