"""Predictor with five hypotheses: people keep going, stop, turn back or turn aside.

Measurements are recovered from the tracks, which is valid only for a tracker whose estimates follow
a Kalman update. A tracker smooths: it takes a share K of each innovation, so that its estimate lags
when a person stops or turns, with correlated errors. From two states at successive observations,
the measured position can be computed.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import Model
from cohelm.messages import People, Predictions
from cohelm.perception.prediction.interacting_models import (
    FilterStates,
    ImmState,
    ModelBank,
    predict_hypotheses,
    update_models,
)
from cohelm.perception.sensor_clocks import CLOCK_RESET

_MIN_GAIN = 0.25
"""Lower bound of K: a small difference must not become a large one."""
_MAX_RATIO = 1.4
"""Upper bound of P_pv dt / P_pp: 3/2 is its limit for infinite noise."""
_TINY = 1e-18


def axis_covariance(covariance: Floats) -> Floats:
    """(P_pp, P_pv, P_vv) of states' covariances (n, 4, 4), averaged over the two axes; (n, 3)."""
    blocks = ((0, 0), (0, 2), (2, 2))
    return np.stack(
        [0.5 * (covariance[:, i, j] + covariance[:, i + 1, j + 1]) for i, j in blocks], axis=-1
    )


def recover_measurements(
    expected: Floats, before: Floats, position: Floats, after: Floats, dt: Floats
) -> tuple[Floats, Floats]:
    """Compute the measured positions, (n, 2) m, and the tracker's variances of them, (n,) m².

    Valid only for a tracker with a Kalman update of a constant-velocity state.

    The filter's process noise is found as well, so that no parameter of it is needed: a position
    measurement changes the information P⁻¹ in its first element only. With P⁻ = s (F P Fᵀ + q Q₁),
    Q₁ as in ``kalman.predict`` for q = 1, therefore ::

        P⁻_pv / P⁻_pp = P_pv / P_pp           which is linear in q
        P⁻_pp / det P⁻ = P_pp / det P         which then gives s

    where s ≥ 1 is the filter's covariance inflation. Then K = 1 − P_pp / P⁻_pp on either axis, and
    z = p⁻ + (p − p⁻) / K of variance P_pp / K. Without correlation of position and velocity
    there was no filter, and z = p. Any other tracker gives a wrong z.

    Args:
        expected: p⁻, predicted from the earlier state, (n, 2) m.
        before: (P_pp, P_pv, P_vv) of the earlier state, (n, 3).
        position: p, the present estimate, (n, 2) m.
        after: (P_pp, P_pv, P_vv) now, (n, 3).
        dt: time between the states, (n,) s, > 0.
    """
    pp, pv, vv = after.T
    wide_pv = before[:, 1] + dt * before[:, 2]
    wide = before[:, 0] + dt * (before[:, 1] + wide_pv)
    ratio = pv / np.maximum(pp, _TINY)
    stiff = dt**2 * (0.5 - dt * np.minimum(ratio, _MAX_RATIO / dt) / 3.0)
    q = np.maximum(ratio * wide - wide_pv, 0.0) / stiff
    wide, wide_pv = wide + q * dt**3 / 3.0, wide_pv + 0.5 * q * dt**2
    wide_vv = before[:, 2] + q * dt
    doubt = wide * (pp * vv - pv**2) / np.maximum(pp * (wide * wide_vv - wide_pv**2), _TINY)
    share = 1.0 - pp / np.maximum(wide * np.maximum(doubt, 1.0), _TINY)
    gain = np.where(pv > 0.0, np.clip(share, _MIN_GAIN, 1.0), 1.0)
    return expected + (position - expected) / gain[:, None], pp / gain


_COASTED = 1e-9
"""Largest deviation of a coasting track's mean from its prediction, m and m/s."""
HYPOTHESES = ("keeps_going", "stops", "turns_back", "turns_aside_left", "turns_aside_right")


class MotionModel(Model):
    """Motion at a constant velocity."""

    share: float = Field(gt=0.0, le=100.0)
    """Frequency with which the model is entered, relative to the others."""
    duration: float = Field(gt=0.0, le=100.0)
    """Mean duration, s."""
    process_noise: float = Field(gt=0.0, le=10.0)
    """q of the velocity between observations, m²/s³."""
    horizon_noise: float = Field(gt=0.0, le=10.0)
    """q of the velocity over the prediction horizon, m²/s³."""
    speed_uncertainty: float = Field(ge=0.0, le=1.0)
    """Deviation of the predicted velocity, as a share of the nominal speed."""


class ManoeuvreModel(MotionModel):
    """Motion that changes to another velocity."""

    time_constant: float = Field(gt=0.0, le=10.0)
    """Time constant of the change, s."""
    velocity_deviation: float = Field(ge=0.0, le=5.0)
    """Deviation of the predicted velocity at any speed, m/s: a standing person may start."""


class Hypotheses:
    """Five futures with probabilities from recent motion; see ``interacting_models``.

    ============================ ======================================================
    ``keeps_going``              keeps the velocity, or remains standing; evenly or not
    ``stops``                    stops, abruptly or gently
    ``turns_back``               changes to the reversed nominal velocity
    ``turns_aside_left, -right`` changes to the nominal velocity turned by ``turn_angle``
    ============================ ======================================================

    Evidence are the measured positions (``measurement_recovery``), at most one per ``interval``, so
    that the call rate of the predictor does not matter; a coasting track gives none. People are
    identified by id, as long as they are tracked. About a second after a change the motion is usual
    again: a person who has stopped keeps standing.
    """

    class Parameters(Model):
        """Found by search on filmed crowds and simulated changes, see docs/prediction.md."""

        steady: MotionModel = MotionModel(
            share=0.79,
            duration=7.4,
            process_noise=0.00038,
            horizon_noise=0.03,
            speed_uncertainty=0.059,
        )
        """Keeps going evenly."""
        uneven: MotionModel = MotionModel(
            share=0.023,
            duration=6.4,
            process_noise=0.019,
            horizon_noise=0.034,
            speed_uncertainty=0.014,
        )
        """Keeps going unevenly: speeds up, swerves, starts."""
        hesitate: ManoeuvreModel = ManoeuvreModel(
            share=0.03,
            duration=0.94,
            process_noise=0.058,
            horizon_noise=0.028,
            speed_uncertainty=0.21,
            time_constant=0.21,
            velocity_deviation=0.088,
        )
        """Keeps going, a little slower for a while."""
        hesitation_speed: float = Field(0.9, gt=0.0, lt=1.0)
        """Share of the nominal speed during hesitation."""
        stop_abruptly: ManoeuvreModel = ManoeuvreModel(
            share=0.3,
            duration=2.6,
            process_noise=0.023,
            horizon_noise=0.0039,
            speed_uncertainty=0.43,
            time_constant=0.23,
            velocity_deviation=0.011,
        )
        stop_gently: ManoeuvreModel = ManoeuvreModel(
            share=0.066,
            duration=1.0,
            process_noise=0.073,
            horizon_noise=0.022,
            speed_uncertainty=0.63,
            time_constant=0.86,
            velocity_deviation=0.015,
        )
        turn_back: ManoeuvreModel = ManoeuvreModel(
            share=0.008,
            duration=1.7,
            process_noise=0.94,
            horizon_noise=0.089,
            speed_uncertainty=0.87,
            time_constant=0.23,
            velocity_deviation=0.45,
        )
        turn_aside: ManoeuvreModel = ManoeuvreModel(
            share=0.025,
            duration=1.5,
            process_noise=0.73,
            horizon_noise=0.089,
            speed_uncertainty=0.65,
            time_constant=0.25,
            velocity_deviation=0.43,
        )
        """Turns aside; to each side."""
        turn_angle: float = Field(1.1, gt=0.0, lt=math.pi)
        """Angle of a turn aside, rad."""
        usual_time_constant: float = Field(0.16, gt=0.0, le=60.0)
        """Time constant with which the nominal velocity follows a person who keeps going, s."""
        noise: float = Field(1.1, ge=0.0, le=100.0)
        """Variance of a measured position, as a multiple of the tracker's value (a factor)."""
        min_noise: float = Field(0.0027, gt=0.0, le=1.0)
        """Additional standard deviation of a measured position, m: walking people sway."""
        student_dof: float = Field(17.0, gt=0.0, le=1000.0)
        """ν of eq. (3) in ``interacting_models``: a low value discounts outliers."""
        new_person_change: float = Field(0.2, gt=0.0, le=1.0)
        """Odds of a change for a new person, relative to others: the usual motion is unknown."""
        slow: float = Field(0.13, gt=0.0, le=5.0)
        """Nominal speed below which stopping is the same as keeping going, m/s."""
        standing_stops: float = Field(0.49, ge=0.0, le=1.0)
        """Share of stopping that is reported as such for a standing person, and means staying; the
        rest is reported as keeping going."""
        sharpness: float = Field(0.77, gt=0.0, le=10.0)
        """Exponent of the reported probabilities; 1 leaves them unchanged."""
        interval: float = Field(0.09, gt=0.0, le=2.0)
        """Least time between two observations used, s: a little less than between two scans."""
        memory_time: float = Field(2.0, gt=0.0, le=60.0)
        """Time without an observation after which a person counts as new, s."""
        max_deviation: float = Field(2.0, gt=0.0, le=20.0)
        """m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = p = parameters or self.Parameters()
        self.bank = _model_bank(p)
        change = np.where(self.bank.hypothesis == 0, 1.0, p.new_person_change)
        odds = self.bank.stationary * change
        self._initial: Floats = odds / odds.sum()

    def predict(
        self, people: People, steps: int, step: float, memory: ImmState | None
    ) -> tuple[Predictions, ImmState]:
        """See :meth:`Predictor.predict`."""
        p = self.parameters
        state = self._update(people, _recalled(people, memory, self._initial, p.memory_time))
        since = np.maximum(people.time - state.time, 0.0)
        states = FilterStates(*(getattr(state, name) for name in FilterStates._fields))
        ahead = predict_hypotheses(states, self.bank, since, step * np.arange(steps + 1.0))
        predictions = Predictions(
            step=step,
            names=HYPOTHESES,
            weight=self._reported(ahead.weight, state.nominal_velocity),
            mean=people.mean[:, None, None, :2] + ahead.displacement,
            velocity=ahead.velocity,
            deviation=np.minimum(ahead.deviation, p.max_deviation),
        )
        return predictions, state

    def _reported(self, weight: Floats, nominal_velocity: Floats) -> Floats:
        """Reported probabilities (n, h) from those of the filters."""
        p = self.parameters
        # For a person who stands, to stop is to keep going: a part of the weight moves.
        square = nominal_velocity[:, 0] ** 2 + nominal_velocity[:, 1] ** 2
        stops = p.standing_stops + (1.0 - p.standing_stops) * square / (square + p.slow**2)
        reported = weight.copy()
        reported[:, 0] += (1.0 - stops) * reported[:, 1]
        reported[:, 1] *= stops
        reported = reported**p.sharpness
        out: Floats = reported / reported.sum(axis=1, keepdims=True)
        return out

    def _update(self, people: People, state: ImmState) -> ImmState:
        """State after the observations of people that were seen and are due."""
        p = self.parameters
        dt = people.time - state.time
        expected = state.tracker_mean.copy()
        expected[:, :2] += dt[:, None] * state.tracker_mean[:, 2:]
        covariance = axis_covariance(people.covariance)
        coasted = np.abs(people.mean - expected).max(axis=1, initial=0.0) < _COASTED
        due = np.flatnonzero((dt >= p.interval) & ~(coasted & (covariance[:, 1] > 0.0)))
        if len(due) == 0:
            return state
        new = _rows(state, due)
        before, after = new["tracker_covariance"], covariance[due]
        position, variance = recover_measurements(
            expected[due, :2], before, people.mean[due, :2], after, dt[due]
        )
        states = FilterStates(*(new[name] for name in FilterStates._fields))
        update_models(dt[due], position, p.noise * variance + p.min_noise**2, states, self.bank)
        new["time"] = np.full(len(due), people.time)
        new["tracker_mean"], new["tracker_covariance"] = people.mean[due], after
        return _with_rows(state, due, new)


def _model_bank(p: Hypotheses.Parameters) -> ModelBank:
    cos, sin = math.cos(p.turn_angle), math.sin(p.turn_angle)
    # (index of the hypothesis, model, its target velocity relative to the nominal one)
    table: list[tuple[int, MotionModel, tuple[float, float]]] = [
        (0, p.steady, (0.0, 0.0)),
        (0, p.uneven, (0.0, 0.0)),
        (0, p.hesitate, (p.hesitation_speed, 0.0)),
        (1, p.stop_abruptly, (0.0, 0.0)),
        (1, p.stop_gently, (0.0, 0.0)),
        (2, p.turn_back, (-1.0, 0.0)),
        (3, p.turn_aside, (cos, sin)),
        (4, p.turn_aside, (cos, -sin)),
    ]
    models = [model for _, model, _ in table]
    entry = np.array([m.share for m in models])
    return ModelBank(
        hypothesis=np.array([index for index, _, _ in table]),
        entry_probability=entry / entry.sum(),
        exit_rate=np.array([1.0 / m.duration for m in models]),
        time_constant=np.array([getattr(m, "time_constant", np.inf) for m in models]),
        process_noise=np.array([m.process_noise for m in models]),
        target=np.array([target for _, _, target in table]),
        horizon_noise=np.array([m.horizon_noise for m in models]),
        speed_uncertainty=np.array([m.speed_uncertainty for m in models]),
        velocity_deviation=np.array([getattr(m, "velocity_deviation", 0.0) for m in models]),
        nominal_time_constant=p.usual_time_constant,
        student_dof=p.student_dof,
    )


_ROWS = ("time", *FilterStates._fields, "tracker_mean", "tracker_covariance")


def _rows(state: ImmState, which: Integers | Booleans) -> dict[str, Floats]:
    """Copies of the rows of some people."""
    return {name: getattr(state, name)[which].copy() for name in _ROWS}


def _with_rows(state: ImmState, which: Integers | Booleans, rows: dict[str, Floats]) -> ImmState:
    changed = {name: getattr(state, name).copy() for name in _ROWS}
    for name in _ROWS:
        changed[name][which] = rows[name]
    return replace(state, **changed)


def _recalled(
    people: People, memory: ImmState | None, initial: Floats, memory_time: float
) -> ImmState:
    """States of ``people`` in their order; a new person starts from the tracker's estimate.

    initial: probabilities of a new person's models, (m,).
    """
    n, m = len(people), len(initial)
    axes = axis_covariance(people.covariance)
    state = ImmState(
        id=people.id,
        time=np.full(n, people.time),
        mean=np.repeat(people.mean[:, None], m, axis=1),
        covariance=np.repeat(axes[:, None], m, axis=1),
        mode_probability=np.tile(initial, (n, 1)),
        nominal_velocity=people.mean[:, 2:],
        tracker_mean=people.mean,
        tracker_covariance=axes,
    )
    if memory is None or n == 0 or len(memory.id) == 0:
        return state
    order = np.argsort(memory.id, kind="stable")
    last = len(order) - 1
    old = order[np.minimum(np.searchsorted(memory.id, people.id, sorter=order), last)]
    since = people.time - memory.time[old]
    known = (memory.id[old] == people.id) & (since >= -CLOCK_RESET) & (since <= memory_time)
    return _with_rows(state, known, _rows(memory, old[known]))
