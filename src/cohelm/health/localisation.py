"""Health of the localisation: good, doubtful or lost, from the fit of sweeps to the map."""

from __future__ import annotations

import math

import numpy as np

from cohelm.health.map_fit import MapFit
from cohelm.health.parameters import HealthParameters
from cohelm.health.values import LocalisationHealth, LocalisationState
from cohelm.messages import Observation

_MIN_BEAMS = 10
"""Informative beams without which a sweep judges nothing."""
_GOOD, _DOUBTFUL = LocalisationState.GOOD, LocalisationState.DOUBTFUL
_LOST, _UNKNOWN = LocalisationState.LOST, LocalisationState.UNKNOWN


def update_localisation(
    before: LocalisationHealth,
    fit: MapFit,
    elapsed: float,
    time: float,
    p: HealthParameters,
    *,
    carried: bool = False,
) -> LocalisationHealth:
    """Add the fit of a sweep; one that shows too little of the map changes nothing.

    Args:
        before: health before.
        fit: of the sweep.
        elapsed: time since the last sweep, s.
        time: of the sweep, s.
        p: parameters.
        carried: the view broke off, and less of it is on the map since.
    """
    enough = fit.hit + fit.through + fit.missing >= _MIN_BEAMS
    if fit.informative < p.min_informative or not enough:
        state = _LOST if carried else before.state
        return _with(before, state, before.contradiction, before.offset, fit, time)
    share = 1.0 if before.state is _UNKNOWN else 1.0 - math.exp(-elapsed / p.smoothing)
    contradiction = before.contradiction + share * (fit.contradiction - before.contradiction)
    offset = fit.offset if fit.gain >= p.min_gain else np.zeros(3)
    offset = before.offset + share * (offset - before.offset)
    state = _LOST if carried else _state(contradiction, offset, p)
    return _with(before, state, contradiction, offset, fit, time)


def stated_doubt(observation: Observation, p: HealthParameters) -> bool:
    """Check the covariance that the localiser states for its own pose."""
    covariance = observation.pose_covariance
    if covariance is None:
        return False
    return not float(np.sqrt(np.trace(covariance[:2, :2]) / 2.0)) < p.doubtful_deviation


def _state(contradiction: float, offset: np.ndarray, p: HealthParameters) -> LocalisationState:
    far, turn = math.hypot(offset[0], offset[1]), abs(float(offset[2]))
    if contradiction >= p.lost_share or far >= p.lost_offset or turn >= p.lost_turn:
        return _LOST
    if contradiction >= p.doubtful_share or far >= p.doubtful_offset or turn >= p.doubtful_turn:
        return _DOUBTFUL
    return _GOOD


def _with(
    before: LocalisationHealth,
    state: LocalisationState,
    contradiction: float,
    offset: np.ndarray,
    fit: MapFit,
    time: float,
) -> LocalisationHealth:
    return LocalisationHealth(
        state=state,
        contradiction=contradiction,
        informative=fit.informative,
        offset=offset,
        since=before.since if state is before.state else time,
    )
