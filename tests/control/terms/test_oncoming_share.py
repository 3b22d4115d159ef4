"""Share of the oncoming margin."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.control.terms.constraints.prediction_selection import oncoming_share
from cohelm.testing.scenes import walkers

POSE = np.array([1.0, 2.0, 0.4])
angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.0, 2.0)


def walking(*ways, at=(3.0, 3.0)):
    """(speed, direction relative to the robot's) each."""
    turned = [(speed, POSE[2] + angle) for speed, angle in ways]
    return walkers([[*at, v * math.cos(a), v * math.sin(a)] for v, a in turned])


@given(st.floats(0.01, 2.0), angles, st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
def test_for_one_person_it_is_the_cosine_of_the_direction(speed, angle, at):
    expected = max(-math.cos(angle), 0.0)
    assert oncoming_share(walking((speed, angle), at=at), POSE) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_it_is_divided_among_all_walking_people(count):
    coming = [(1.0, math.pi)] * count
    assert oncoming_share(walking(*coming), POSE) == pytest.approx(1.0 / count)
    standing = [(0.0, 0.0)] * 3
    assert oncoming_share(walking(*coming, *standing), POSE) == pytest.approx(1.0 / count)
    away = [(1.0, 0.0)] * count
    shared = 0.5 / (2 * count)  # half of them come
    assert oncoming_share(walking(*coming, *away), POSE) == pytest.approx(shared)


def test_it_is_zero_without_walking_people():
    assert oncoming_share(walkers(np.empty((0, 4))), POSE) == 0.0
    assert oncoming_share(walking((0.0, 1.0), (0.0, 2.0)), POSE) == 0.0


@given(st.lists(st.tuples(speeds, angles), min_size=2, max_size=5))
def test_it_is_continuous_when_a_person_stops(ways):
    one, *rest = ways
    stops = oncoming_share(walking((1e-9, one[1]), *rest), POSE)
    if sum(speed for speed, _ in rest) > 1e-3:
        assert stops == pytest.approx(oncoming_share(walking(*rest), POSE), abs=1e-5)
    assert 0.0 <= stops <= 1.0
