"""How much of a thing lies beside another."""

import numpy as np
import pytest

from cohelm.perception.cloud_detection.columns import touching_share

NEAR = 0.15


def by_every_pair(centre, labels, asked, bodies):
    apart = np.hypot(*(centre[:, None] - centre[None]).transpose(2, 0, 1))
    meets = ((apart <= NEAR) & (labels[:, None] != labels[None]) & asked[None]).any(axis=1)
    own = [asked & (labels == body) for body in range(bodies)]
    return np.array([(meets & mine).sum() / max(mine.sum(), 1) for mine in own])


@pytest.mark.parametrize("seed", range(20))
def test_it_is_what_comparing_every_pair_gives(seed):
    rng = np.random.default_rng(seed)
    count = rng.integers(0, 400)
    centre = np.round(rng.uniform(-3.0, 3.0, (count, 2)) / 0.05) * 0.05
    labels, asked = rng.integers(-1, 8, count), rng.random(count) < 0.7
    assert touching_share(centre, labels, asked, NEAR, 6) == pytest.approx(
        by_every_pair(centre, labels, asked, 6)
    )


def test_nothing_touches_nothing():
    none = np.empty(0, dtype=np.int64)
    assert (touching_share(np.empty((0, 2)), none, none.astype(bool), NEAR, 3) == 0.0).all()
