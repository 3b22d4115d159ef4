"""Where people will be: they keep going, stop, turn back or turn aside."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.messages import People, Predictions
from cohelm.perception.clock import RAN_BACK
from cohelm.perception.modes import ModeState, ModeTable, look
from cohelm.perception.modes_ahead import ahead
from cohelm.perception.unsmoothed import by_axis, unsmoothed

_COASTED = 1e-9
"""Whose filtered mean is where it was going, m and m/s, was not seen since."""
HYPOTHESES = ("keeps_going", "stops", "turns_back", "turns_aside_left", "turns_aside_right")


class Going(Model):
    """A manner of keeping on at one's velocity."""

    share: float = Field(gt=0.0, le=100.0)
    """How often it is taken up, beside the other manners."""
    lasts: float = Field(gt=0.0, le=100.0)
    """On average, s."""
    agility: float = Field(gt=0.0, le=10.0)
    """q of the velocity from one look to the next, m²/s³."""
    wander: float = Field(gt=0.0, le=10.0)
    """q of the velocity over the time ahead, m²/s³."""
    doubt: float = Field(ge=0.0, le=1.0)
    """Deviation of the velocity ahead, as a share of the usual speed."""


class Change(Going):
    """A manner of coming to another velocity."""

    settling: float = Field(gt=0.0, le=10.0)
    """Time constant of coming to it, s."""
    stir: float = Field(ge=0.0, le=5.0)
    """Deviation of the velocity ahead at any speed, m/s: who stands may start."""


class Hypotheses:
    """Five futures with their probabilities, from what each person did lately; see ``modes``.

    ============================ ========================================================
    ``keeps_going``              keeps the velocity, or stays where he stands; evenly or not
    ``stops``                    comes to a stand, at once or gently
    ``turns_back``               comes to the usual velocity reversed
    ``turns_aside_left, -right`` comes to the usual velocity turned by ``aside``
    ============================ ========================================================

    Positions of people are the evidence, as they were seen (``unsmoothed``), one look every
    ``interval`` at most, so that it does not matter how often the predictor is asked; who only
    coasts tells nothing. Everyone is known by id, for as long as he is told. A second or so after a
    change everything is as usual again: who has stopped is one who keeps standing.
    """

    class Parameters(Model):
        """Found by search on filmed crowds and simulated changes, see docs/prediction.md."""

        steady: Going = Going(share=0.79, lasts=7.4, agility=0.00038, wander=0.03, doubt=0.059)
        """Keeps going evenly."""
        uneven: Going = Going(share=0.023, lasts=6.4, agility=0.019, wander=0.034, doubt=0.014)
        """Keeps going, but not evenly: speeds up, swerves, starts."""
        falters: Change = Change(
            share=0.03,
            lasts=0.94,
            agility=0.058,
            wander=0.028,
            doubt=0.21,
            settling=0.21,
            stir=0.088,
        )
        """Keeps going, a little slower for a while."""
        slack: float = Field(0.9, gt=0.0, lt=1.0)
        """Share of the usual speed that who falters comes to."""
        halts: Change = Change(
            share=0.3,
            lasts=2.6,
            agility=0.023,
            wander=0.0039,
            doubt=0.43,
            settling=0.23,
            stir=0.011,
        )
        """Stops at once."""
        slows: Change = Change(
            share=0.066,
            lasts=1.0,
            agility=0.073,
            wander=0.022,
            doubt=0.63,
            settling=0.86,
            stir=0.015,
        )
        """Stops gently."""
        back: Change = Change(
            share=0.008, lasts=1.7, agility=0.94, wander=0.089, doubt=0.87, settling=0.23, stir=0.45
        )
        """Turns back."""
        side: Change = Change(
            share=0.025, lasts=1.5, agility=0.73, wander=0.089, doubt=0.65, settling=0.25, stir=0.43
        )
        """Turns aside, to each side."""
        aside: float = Field(1.1, gt=0.0, lt=math.pi)
        """Angle by which who turns aside turns, rad."""
        habit: float = Field(0.16, gt=0.0, le=60.0)
        """Time constant with which the usual velocity follows who keeps going, s."""
        noise: float = Field(1.1, ge=0.0, le=100.0)
        """Variance of a seen position, as a multiple of what the tracker takes it for."""
        least_noise: float = Field(0.0027, gt=0.0, le=1.0)
        """Deviation of a seen position beyond that: walking sways, m."""
        tails: float = Field(17.0, gt=0.0, le=1000.0)
        """ν of eq. (3) in ``modes``: how little one odd look alone proves."""
        newcomers: float = Field(0.2, gt=0.0, le=1.0)
        """Odds that who is seen for the first time changes, beside anybody's: of what is usual for
        him nothing is known yet."""
        slow: float = Field(0.13, gt=0.0, le=5.0)
        """Usual speed below which to stop is to go on as before, m/s."""
        staying: float = Field(0.49, ge=0.0, le=1.0)
        """Of who stands, the share of stopping that is told as such, and means that he stays put;
        the rest is that he keeps going, that is standing."""
        sharpness: float = Field(0.77, gt=0.0, le=10.0)
        """Power that the probabilities are raised to in the end; 1 leaves them."""
        interval: float = Field(0.09, gt=0.0, le=2.0)
        """Least time between two looks that count, s: a little below that between two scans."""
        forgotten: float = Field(2.0, gt=0.0, le=60.0)
        """Whoever was not looked at for so long is seen as if new, s."""
        largest_deviation: float = Field(2.0, gt=0.0, le=20.0)
        """m."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.modes = _modes(self.parameters)
        odds = self.modes.usual * np.where(
            self.modes.hypothesis == 0, 1.0, self.parameters.newcomers
        )
        self.at_first: Floats = odds / odds.sum()

    def predict(
        self, people: People, steps: int, step: float, memory: ModeState | None
    ) -> tuple[Predictions, ModeState]:
        """See :meth:`Predictor.predict`."""
        state = self._look(
            people, _recalled(people, memory, self.at_first, self.parameters.forgotten)
        )
        since = np.maximum(people.time - state.time, 0.0)
        times = step * np.arange(steps + 1.0)
        weight, way, velocity, deviation = ahead(state, self.modes, since, times)
        predictions = Predictions(
            step=step,
            names=HYPOTHESES,
            weight=self._told(weight, state.wont),
            mean=people.mean[:, None, None, :2] + way,
            velocity=velocity,
            deviation=np.minimum(deviation, self.parameters.largest_deviation),
        )
        return predictions, state

    def _told(self, weight: Floats, wont: Floats) -> Floats:
        """Probabilities of the hypotheses (n, h) as they are told, from those of their modes."""
        p = self.parameters
        square = wont[:, 0] ** 2 + wont[:, 1] ** 2
        stops = p.staying + (1.0 - p.staying) * square / (square + p.slow**2)
        told = weight.copy()
        told[:, 0] += (1.0 - stops) * told[:, 1]
        told[:, 1] *= stops
        told = told**p.sharpness
        out: Floats = told / told.sum(axis=1, keepdims=True)
        return out

    def _look(self, people: People, state: ModeState) -> ModeState:
        """``state`` after those who are due, and were seen, have been looked at."""
        p, t = self.parameters, self.modes
        dt = people.time - state.time
        gone_on = state.told.copy()
        gone_on[:, :2] += dt[:, None] * state.told[:, 2:]
        covariance = by_axis(people.covariance)
        coasted = np.abs(people.mean - gone_on).max(axis=1, initial=0.0) < _COASTED
        due = np.flatnonzero((dt >= p.interval) & ~(coasted & (covariance[:, 1] > 0.0)))
        if len(due) == 0:
            return state
        new = _rows(state, due)
        position, variance = unsmoothed(
            gone_on[due, :2],
            new["told_covariance"],
            people.mean[due, :2],
            covariance[due],
            dt[due],
        )
        look(
            dt[due],
            position,
            p.noise * variance + p.least_noise**2,
            new["mean"],
            new["covariance"],
            new["weight"],
            new["wont"],
            t.share,
            t.rate,
            t.settling,
            t.agility,
            t.aim,
            p.habit,
            p.tails,
        )
        new["time"] = np.full(len(due), people.time)
        new["told"], new["told_covariance"] = people.mean[due], covariance[due]
        return _with_rows(state, due, new)


def _modes(p: Hypotheses.Parameters) -> ModeTable:
    turn = (math.cos(p.aside), math.sin(p.aside))
    manners: list[tuple[int, Going, tuple[float, float]]] = [
        (0, p.steady, (0.0, 0.0)),
        (0, p.uneven, (0.0, 0.0)),
        (0, p.falters, (p.slack, 0.0)),
        (1, p.halts, (0.0, 0.0)),
        (1, p.slows, (0.0, 0.0)),
        (2, p.back, (-1.0, 0.0)),
        (3, p.side, turn),
        (4, p.side, (turn[0], -turn[1])),
    ]
    each = [manner for _, manner, _ in manners]
    share = np.array([m.share for m in each])
    return ModeTable(
        hypothesis=np.array([which for which, _, _ in manners]),
        share=share / share.sum(),
        rate=np.array([1.0 / m.lasts for m in each]),
        settling=np.array([m.settling if isinstance(m, Change) else np.inf for m in each]),
        agility=np.array([m.agility for m in each]),
        aim=np.array([aim for _, _, aim in manners]),
        wander=np.array([m.wander for m in each]),
        doubt=np.array([m.doubt for m in each]),
        stir=np.array([m.stir if isinstance(m, Change) else 0.0 for m in each]),
    )


_ROWS = ("time", "mean", "covariance", "weight", "wont", "told", "told_covariance")


def _rows(state: ModeState, which: Integers | Booleans) -> dict[str, Floats]:
    """Copies of what is known of some."""
    return {name: getattr(state, name)[which].copy() for name in _ROWS}


def _with_rows(state: ModeState, which: Integers | Booleans, rows: dict[str, Floats]) -> ModeState:
    changed = {}
    for name in _ROWS:
        changed[name] = getattr(state, name).copy()
        changed[name][which] = rows[name]
    return replace(state, **changed)


def _recalled(
    people: People, memory: ModeState | None, at_first: Floats, forgotten: float
) -> ModeState:
    """What is known of each of ``people``, in their order; of a new one what the tracker says.

    at_first: probabilities of a new one's modes, (m,).
    """
    n, m = len(people), len(at_first)
    axes = by_axis(people.covariance)
    state = ModeState(
        id=people.id,
        time=np.full(n, people.time),
        mean=np.repeat(people.mean[:, None], m, axis=1),
        covariance=np.repeat(axes[:, None], m, axis=1),
        weight=np.tile(at_first, (n, 1)),
        wont=people.mean[:, 2:],
        told=people.mean,
        told_covariance=axes,
    )
    if memory is None or n == 0 or len(memory.id) == 0:
        return state
    order = np.argsort(memory.id, kind="stable")
    last = len(order) - 1
    old = order[np.minimum(np.searchsorted(memory.id, people.id, sorter=order), last)]
    since = people.time - memory.time[old]
    known = (memory.id[old] == people.id) & (since >= -RAN_BACK) & (since <= forgotten)
    return _with_rows(state, known, _rows(memory, old[known]))
