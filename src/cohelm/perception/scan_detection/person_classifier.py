"""Learned classifier of candidates in planar scans: an ensemble of small regression trees.

The sum of the leaves is the log-odds of a person for equal numbers of people and other objects.
Training is in ``cohelm.benchmarks.perception``, the model card in docs/person-classifier.md.
"""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers, read_only
from cohelm.kernels import CACHED

DEPTH = 3
"""Depth of every tree."""
MAX_LOG_ODDS = 4.0
"""Bound of the log-odds either way."""
_FILE = "person_classifier.npz"


class TreeEnsemble(NamedTuple):
    """t complete binary trees; node k has the children 2k + 1 and 2k + 2."""

    feature: Integers
    """(t, 7) column of ``FEATURES`` that each node compares."""
    threshold: Floats
    """(t, 7) a value up to it goes to the first child."""
    leaf: Floats
    """(t, 8) log-odds."""
    offset: float
    """Log-odds without any tree."""


_NODES = 2**DEPTH - 1
NO_TREES = TreeEnsemble(
    np.zeros((0, _NODES), dtype=np.int64), np.zeros((0, _NODES)), np.zeros((0, _NODES + 1)), 0.0
)
"""Classifier without an opinion."""


@lru_cache(maxsize=1)
def shipped_classifier() -> TreeEnsemble:
    """Classifier that comes with cohelm."""
    with (files(__package__) / _FILE).open("rb") as file, np.load(file) as data:
        return TreeEnsemble(
            read_only(data["feature"].astype(np.int64)),
            read_only(data["threshold"].astype(np.float64)),
            read_only(data["leaf"].astype(np.float64)),
            float(data["offset"]),
        )


@njit(**CACHED)
def person_log_odds(features: Floats, trees: TreeEnsemble) -> Floats:
    """ln(p / (1 − p)) of a person for candidates with features (d, f); (d,)."""
    out = np.full(len(features), trees.offset)
    inner = trees.feature.shape[1]
    for i in range(len(features)):
        for t in range(len(trees.feature)):
            node = 0
            while node < inner:
                right = features[i, trees.feature[t, node]] > trees.threshold[t, node]
                node = 2 * node + (2 if right else 1)
            out[i] += trees.leaf[t, node - inner]
        out[i] = min(max(out[i], -MAX_LOG_ODDS), MAX_LOG_ODDS)
    return out
