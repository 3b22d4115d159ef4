"""The learned classifier of candidates: its trees, its features, its training."""

import numpy as np
import pytest

from cohelm.benchmarks.perception.held_out import (
    Samples,
    save,
    simulated_samples,
    train,
    training_scan,
)
from cohelm.evaluation.perception.recording_view import NO_MAP
from cohelm.perception import ScanClusters
from cohelm.perception.scan_detection.candidate_features import FEATURES
from cohelm.perception.scan_detection.person_classifier import (
    MAX_LOG_ODDS,
    NO_TREES,
    TreeEnsemble,
    person_log_odds,
    shipped_classifier,
)


def test_a_tree_leads_to_its_leaf():
    # Left at the root below 1, then right above 2: leaf 1 of 8 subtrees, counted from the left.
    feature = np.array([[0, 1, 1, 0, 0, 0, 0]])
    threshold = np.array([[1.0, 2.0, 2.0, 9.0, 9.0, 9.0, 9.0]])
    trees = TreeEnsemble(feature, threshold, np.arange(8.0)[None] / 4.0, 0.5)
    rows = np.array([[0.0, 0.0], [0.0, 3.0], [2.0, 0.0], [2.0, 3.0]])
    assert person_log_odds(rows, trees).tolist() == [0.5, 1.0, 1.5, 2.0]


def test_without_trees_nothing_is_known_and_the_odds_are_bounded():
    rows = np.zeros((2, len(FEATURES)))
    assert person_log_odds(rows, NO_TREES).tolist() == [0.0, 0.0]
    high = NO_TREES._replace(offset=99.0)
    assert person_log_odds(rows, high).tolist() == [MAX_LOG_ODDS] * 2


def test_the_shipped_model_compares_known_features():
    trees = shipped_classifier()
    assert trees.feature.min() >= 0
    assert trees.feature.max() < len(FEATURES)
    assert np.isfinite(trees.leaf).all()


@pytest.fixture(scope="module")
def samples():
    return simulated_samples(range(60))


def test_training_is_repeatable_and_a_saved_model_is_the_trained_one(samples, tmp_path):
    trees, again = train(samples, []), train(samples, [])
    assert all(np.array_equal(a, b) for a, b in zip(trees, again, strict=True))
    save(trees, tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz") as data:
        assert np.array_equal(data["leaf"].astype(float), trees.leaf)
        assert np.array_equal(data["threshold"].astype(float), trees.threshold)


def test_the_classifier_tells_people_from_furniture_in_scenes_it_never_saw(samples):
    trees = shipped_classifier()
    fresh = simulated_samples(range(100_000, 100_060))
    odds = person_log_odds(fresh.features, trees)
    # The share of pairs of a person and an object in the right order; 0.5 is chance.
    pairs = odds[fresh.person][:, None] - odds[~fresh.person][None]
    assert np.mean(pairs > 0.0) > 0.8
    assert isinstance(samples, Samples)


def test_features_do_not_depend_on_the_pose_of_the_robot():
    scene, detector = training_scan(3), ScanClusters(classifier=NO_TREES)
    here = detector.candidates(scene.scan, scene.pose, NO_MAP).features
    there = detector.candidates(scene.scan, np.array([5.0, -2.0, 0.7]), NO_MAP).features
    assert here.shape[1] == len(FEATURES)
    assert there == pytest.approx(here, abs=1e-6)
