"""Contract of ``perception.Predictor``."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import People, Predictions
from cohelm.perception.api import Predictor
from cohelm.testing.conformance import TOLERANCE, require, require_finite, steady
from cohelm.testing.scenes import straight_on, walkers

_STEP = 0.1


def check_predictor(predictor: Predictor, *, within: float = 1.0) -> None:
    """Check a predictor without people and with three: start at the present, growing deviation.

    Then people appear, vanish and return over several calls, and time runs backwards. Memory must
    be a value: equal calls give equal results, and no call changes an earlier result. The order of
    the people must not matter.

    Raises:
        ConformanceError: naming the violated rule.
    """
    crowd = np.array([[3.0, 0.0, -1.2, 0.0], [2.0, 1.0, 0.0, 0.0], [4.0, -2.0, 0.3, 0.4]])
    for states in (np.empty((0, 4)), crowd):
        people = walkers(states)
        for steps, step in ((1, 0.5), (25, 0.1)):
            _check_prediction(predictor, people, steps, step, None, within)
    memory: Any = None
    names: tuple[str, ...] = ()
    for tick, there in _COMINGS:
        people = _crowd_at(tick * _STEP, crowd, there)
        got, after = _check_prediction(predictor, people, 25, 0.1, memory, within)
        require(not names or got.names == names, "hypotheses must keep their names")
        back, _ = predictor.predict(_crowd_at(tick * _STEP, crowd, there[::-1]), 25, 0.1, memory)
        same = len(back.mean) == len(got.mean) and np.allclose(
            back.mean[::-1], got.mean, rtol=0.0, atol=1e-6
        )
        require(same, "the order of people must not matter")
        memory, names = after, got.names


_COMINGS: tuple[tuple[float, tuple[int, ...]], ...] = (
    *((float(k), (0, 1)) for k in range(4)),
    *((float(k), (1, 0, 2)) for k in range(4, 7)),
    (7.0, (2,)),
    (8.0, ()),
    *((float(k), (2, 0)) for k in range(9, 12)),
    (11.0, (0, 1, 2)),
    (60.0, (0, 1)),
    (2.0, (1, 0)),
)
"""Ticks and the people present: they appear, vanish and return; the clock stands, jumps and runs
backwards."""


def _crowd_at(time: float, crowd: Floats, there: tuple[int, ...]) -> People:
    """Present people of a crowd (n, 4) at ``time``; ids are indices."""
    states = crowd[list(there)].reshape(-1, 4).copy()
    states[:, :2] += time * states[:, 2:]
    return dataclasses.replace(walkers(states, time=time), id=np.array(there, dtype=np.int64))


def _check_prediction(
    predictor: Predictor, people: People, steps: int, step: float, memory: Any, within: float
) -> tuple[Predictions, Any]:
    got: Predictions
    got, after = steady(
        lambda: predictor.predict(people, steps, step, memory),
        inputs=(people, memory),
        what="predict",
        within=within,
    )
    n, h = len(people), len(got.names)
    require(h >= 1, "must name at least one hypothesis")
    shape = (n, h, steps + 1)
    require(
        got.deviation.shape == shape,
        f"must predict (people, hypotheses, steps + 1) = {shape}, predicts {got.deviation.shape}",
    )
    require(got.step == step, "predictions must have the requested step")
    require_finite({"mean": got.mean, "velocity": got.velocity, "deviation": got.deviation})
    require(got.weight >= 0.0, "weights must not be negative")
    require(np.abs(got.weight.sum(axis=1) - 1.0) < TOLERANCE, "a person's weights must sum to 1")
    here = straight_on(people, steps, step).mean[:, :, 0]
    require(
        np.abs(got.mean[:, :, 0] - here) < TOLERANCE,
        "step 0 must be the present position of people",
    )
    require(got.deviation >= 0.0, "deviations must not be negative")
    require(
        np.diff(got.deviation, axis=-1) >= -TOLERANCE,
        "the deviation must not decrease with the prediction time",
    )
    return got, after
