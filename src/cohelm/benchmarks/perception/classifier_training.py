"""Training of the classifier of scan candidates with scikit-learn, seeded, on one core.

Simulated and recorded samples weigh alike, and so do people and other objects in each of them: the
classifier learns from no sensor that people are frequent.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from sklearn.ensemble import HistGradientBoostingClassifier
from threadpoolctl import threadpool_limits

from cohelm.arrays import Floats, read_only
from cohelm.benchmarks.perception.classifier_samples import Samples
from cohelm.perception.scan_detection.person_classifier import DEPTH, TreeEnsemble

TREES = 50
SCENES = 4000
"""Simulated scenes of the shipped model."""
SIMULATED_WEIGHT = 1.0
"""Total weight of the simulated samples beside that of all recorded ones."""


def train(simulated: Samples, recorded: Sequence[Samples]) -> TreeEnsemble:
    """Fit the ensemble to simulated samples and to those of some recordings.

    Deterministic: the same samples give the same trees.
    """
    parts = [simulated, *recorded]
    x = np.concatenate([each.features for each in parts])
    y = np.concatenate([each.person for each in parts])
    model = HistGradientBoostingClassifier(
        max_iter=TREES,
        max_depth=DEPTH,
        learning_rate=0.15,
        l2_regularization=5.0,
        min_samples_leaf=40,
        max_bins=64,
        early_stopping=False,
        random_state=0,
    )
    with threadpool_limits(limits=1):
        model.fit(x, y, sample_weight=_weights(simulated, recorded))
    return _ensemble(model)


def save(trees: TreeEnsemble, file: Path) -> None:
    """Write the ensemble as plain arrays, in single precision."""
    np.savez_compressed(
        file,
        feature=trees.feature.astype(np.int8),
        threshold=trees.threshold.astype(np.float32),
        leaf=trees.leaf.astype(np.float32),
        offset=np.float32(trees.offset),
    )


def _weights(simulated: Samples, recorded: Sequence[Samples]) -> Floats:
    """Weight of each sample.

    Recordings share the weight of people by their counts, and that of other objects evenly.
    """
    people = sum(int(each.person.sum()) for each in recorded)
    rows = [SIMULATED_WEIGHT * _shares(simulated)]
    for each in recorded:
        objects = len(recorded) * max(int((~each.person).sum()), 1)
        rows.append(np.where(each.person, 1.0 / max(people, 1), 1.0 / objects))
    weight = np.concatenate(rows)
    out: Floats = weight * len(weight) / weight.sum()
    return out


def _shares(samples: Samples) -> Floats:
    count = max(int(samples.person.sum()), 1), max(int((~samples.person).sum()), 1)
    return np.where(samples.person, 1.0 / count[0], 1.0 / count[1])


def _ensemble(model: Any) -> TreeEnsemble:
    """Plain arrays of a fitted model; a leaf above the last level fills its whole subtree."""
    inner = 2**DEPTH - 1
    trees = [rows[0].nodes for rows in model._predictors]
    feature = np.zeros((len(trees), inner), dtype=np.int64)
    threshold, leaf = np.zeros((len(trees), inner)), np.zeros((len(trees), inner + 1))
    for t, nodes in enumerate(trees):
        at = [0] * (2 * inner + 1)
        for k in range(2 * inner + 1):
            node = nodes[at[k]]
            if k >= inner:
                leaf[t, k - inner] = node["value"]
                continue
            if node["is_leaf"]:
                at[2 * k + 1] = at[2 * k + 2] = at[k]
                continue
            feature[t, k], threshold[t, k] = node["feature_idx"], node["num_threshold"]
            at[2 * k + 1], at[2 * k + 2] = node["left"], node["right"]
    # Single precision as in the file, so that a saved model equals the trained one.
    return TreeEnsemble(
        read_only(feature),
        read_only(threshold.astype(np.float32).astype(float)),
        read_only(leaf.astype(np.float32).astype(float)),
        float(np.float32(np.ravel(model._baseline_prediction)[0])),
    )
