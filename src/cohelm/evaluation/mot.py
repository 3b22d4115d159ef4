"""Tracks against true ways: the CLEAR MOT and identity measures, as py-motmetrics counts them."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.errors import PluginError


@value
class Compared:
    """One instant: who truly was there, and who was told."""

    true_id: Annotated[Integers, Shape("k")]
    true: Annotated[Floats, Shape("k 2")]
    """m."""
    told_id: Annotated[Integers, Shape("n")]
    told: Annotated[Floats, Shape("n 2")]
    """m."""


@value
class Identities:
    """How well tracks keep to people; Bernardin and Stiefelhagen 2008, Ristani et al. 2016."""

    mota: float
    """1 − (misses + false ones + id changes) / true positions."""
    idf1: float
    """F1 of positions told under the right id."""
    switches: int
    """How often a person's id changed."""
    misses: int
    """True positions that nobody was told at."""
    false: int
    """Told positions where nobody was."""
    positions: int
    """True positions in all."""


def identities(instants: Iterable[Compared], within: float) -> Identities:
    """How well tracks keep to people; a pair farther apart than ``within``, m, never matches.

    Raises:
        PluginError: if py-motmetrics is not installed.
    """
    names = ("mota", "idf1", "num_switches", "num_misses", "num_false_positives", "num_objects")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # divisions by nobody, and what pandas will change
        mm = _motmetrics()
        accumulator = mm.MOTAccumulator(auto_id=True)
        for each in instants:
            apart = np.hypot(*(each.true[:, None] - each.told[None]).transpose(2, 0, 1))
            apart = np.where(apart <= within, apart, np.nan)
            accumulator.update(each.true_id.tolist(), each.told_id.tolist(), apart)
        row = mm.metrics.create().compute(accumulator, metrics=list(names)).iloc[0]
    return Identities(
        mota=float(row["mota"]),
        idf1=float(row["idf1"]),
        switches=int(row["num_switches"]),
        misses=int(row["num_misses"]),
        false=int(row["num_false_positives"]),
        positions=int(row["num_objects"]),
    )


def _motmetrics() -> Any:
    try:
        return importlib.import_module("motmetrics")
    except ImportError:
        raise PluginError(
            "py-motmetrics is not installed, which counts MOTA and IDF1: pip install cohelm[bench]"
        ) from None
