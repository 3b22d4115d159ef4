import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.perception.cloud_detection.columns import LAYER, HeightLimits, build_columns

LIMITS = HeightLimits(-0.3, 0.06, 0.0, 2.0, 3.0)


def columns(points, heights, limits=LIMITS):
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    heights = np.asarray(heights, dtype=float)
    return build_columns(points, heights, limits, 0.05, 10.0, len(points))


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 400))
def test_every_return_above_the_ground_is_in_one_column_whatever_their_order(seed, count):
    rng = np.random.default_rng(seed)
    points, heights = rng.uniform(-1.0, 1.0, (count, 2)), rng.uniform(-0.5, 3.5, count)
    one = columns(points, heights)
    kept = ((heights > 0.06) & (heights <= 3.0)) | (heights < -0.3)
    assert one.returns.sum() == kept.sum()
    order = rng.permutation(count)
    for a, b in zip(one, columns(points[order], heights[order]), strict=True):
        assert np.array_equal(a, b)


def test_a_column_keeps_mean_count_extremes_and_layers():
    # the means lie at (0.11 + 0.13) / 2 and (0.21 + 0.23) / 2; 2.5 m is over the clearance
    seen = columns([[0.11, 0.21], [0.13, 0.23], [0.12, 0.22]], [0.15, 1.72, 2.55])
    assert np.allclose(seen.centre, [[0.12, 0.22]], atol=1e-4)
    assert seen.returns.tolist() == [3]
    assert seen.lowest.tolist() == [0.15]
    assert seen.highest.tolist() == [1.72]
    assert seen.occupied_layers.tolist() == [sum(1 << int(h / LAYER) for h in (0.15, 1.72, 2.55))]


def test_the_ground_grows_with_distance():
    # at 5 m the ground reaches to 0.06 + 0.01 × 5 = 0.11 m
    limits = LIMITS._replace(ground_growth=0.01)
    assert len(columns([[5.0, 0.0], [0.5, 0.0]], [0.1, 0.1], limits).centre) == 1


@pytest.mark.parametrize("height", [0.0, 0.06, -0.2, 3.1])
def test_ground_and_ceiling_make_no_column(height):
    assert len(columns([[1.0, 1.0]], [height]).centre) == 0
