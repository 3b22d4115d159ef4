import numpy as np
import pytest

from cohelm.perception.kalman import predict, update
from cohelm.perception.unsmoothed import by_axis, unsmoothed


def test_finds_what_a_filter_saw():
    # two people through the filter itself; what goes in must come out again
    rng = np.random.default_rng(0)
    mean, covariance = rng.standard_normal((2, 4)), np.tile(0.2 * np.eye(4), (2, 1, 1))
    for dt in (0.1, 0.1, 0.25, 0.4):
        steps, q = np.full(2, dt), np.full(2, 0.15)
        ahead, wide = predict(mean, covariance, steps, q)
        seen = ahead[:, :2] + 0.1 * rng.standard_normal((2, 2))
        after, narrow = update(ahead, wide, seen, np.full(2, 0.06))
        found, variance = unsmoothed(
            ahead[:, :2], by_axis(covariance), after[:, :2], by_axis(narrow), steps, 0.15
        )
        assert found == pytest.approx(seen)
        assert variance == pytest.approx(np.full(2, 0.06**2))
        mean, covariance = after, narrow


def test_takes_as_it_is_what_no_filter_made():
    covariance = by_axis(np.tile(np.diag([0.01, 0.01, 0.1, 0.1]), (1, 1, 1)))
    found, variance = unsmoothed(
        np.zeros((1, 2)), covariance, np.ones((1, 2)), covariance, np.full(1, 0.1), 0.15
    )
    assert found.tolist() == [[1.0, 1.0]]
    assert variance == pytest.approx([0.01])
