import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.cluster import DBSCAN

from cohelm.perception.clustering.dbscan import dbscan


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 150), min_samples=st.integers(1, 6))
def test_agrees_with_scikit_learn(seed, count, min_samples):
    points = np.random.default_rng(seed).uniform(0.0, 3.0, (count, 2))
    ours = dbscan(points, np.full(count, 0.3), min_samples)
    oracle = DBSCAN(eps=0.3, min_samples=min_samples).fit(points)
    assert (ours == oracle.labels_).all()


def test_nothing_has_no_clusters():
    assert len(dbscan(np.empty((0, 2)), np.empty(0), 2)) == 0


@pytest.mark.parametrize(("reach", "labels"), [([0.1, 0.1, 0.1], -1), ([0.1, 0.6, 0.1], 0)])
def test_two_points_are_neighbours_within_the_larger_reach(reach, labels):
    points = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]])
    assert (dbscan(points, np.array(reach), 2) == labels).all()
