"""Clearance from people, and its share for oncoming people."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.robots.clearance import Clearance, oncoming_share, people_margins
from cohelm.testing.scenes import walkers

POSE = np.array([1.0, 2.0, 0.4])
angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.0, 2.0)


def margins(clearance, speed=1.0, *, deviation=0.0, steps=4, **situation):
    """m(t), (L+1,), of one person at a speed, every 0.5 s."""
    velocity = np.tile([speed, 0.0], (1, 1, 3, 1))
    law = clearance.law(**situation)
    return people_margins(velocity, np.full((1, 1, 3), deviation), 0.5, steps, law)[0]


def test_the_clearance_grows_with_prediction_time_up_to_a_bound():
    """0.12 m and 0.1 m/s, 0.25 m at most, beyond the known steps as well."""
    found = margins(Clearance(now=0.12, growth=0.1, upper=0.25))
    assert found == pytest.approx([0.12, 0.17, 0.22, 0.25, 0.25])


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.4), (0.25, 0.7), (0.5, 1.0), (2.0, 1.0)])
def test_standing_people_need_a_share_of_it(speed, share):
    found = margins(Clearance(now=0.2, growth=0.0, standing=0.4), speed)
    assert found == pytest.approx(np.full(5, share * 0.2))


def test_deviations_of_the_prediction_are_added():
    found = margins(Clearance(now=0.1, growth=0.0, deviations=2.0, upper=1.0), deviation=0.15)
    assert found == pytest.approx(np.full(5, 0.4))


def test_oncoming_people_make_it_grow_faster():
    law = Clearance(now=0.1, growth=0.02, oncoming=0.2, upper=1.0)
    assert margins(law, oncoming=0.5) == pytest.approx(0.1 + 0.12 * 0.5 * np.arange(5))


def test_a_therapist_adds_to_all_of_it():
    law = Clearance(now=0.1, growth=0.1, upper=0.2)
    assert margins(law, extra=0.3) == pytest.approx(0.3 + margins(law))


def test_in_a_tight_passage_the_gap_does_not_grow():
    law = Clearance(now=0.1, growth=0.1, upper=0.2)
    assert margins(law, tight=True, extra=0.3) == pytest.approx(np.full(5, 0.4))


def test_a_therapists_addition_holds_in_full_for_standing_people():
    law = Clearance(now=0.1, growth=0.0, standing=0.4)
    assert margins(law, 0.0, extra=0.3) == pytest.approx(np.full(5, 0.34))


def test_a_bound_below_the_gap_now_is_raised_to_it():
    assert margins(Clearance(now=0.3, growth=0.1, upper=0.2)) == pytest.approx(np.full(5, 0.3))


def walking(*courses, at=(3.0, 3.0)):
    """People at (speed, direction relative to the robot's) each."""
    turned = [(speed, POSE[2] + angle) for speed, angle in courses]
    return walkers([[*at, v * math.cos(a), v * math.sin(a)] for v, a in turned])


@given(st.floats(0.5, 2.0), angles, st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
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
def test_it_is_continuous_when_a_person_stops(courses):
    one, *rest = courses
    stops = oncoming_share(walking((1e-9, one[1]), *rest), POSE)
    if sum(speed for speed, _ in rest) > 1e-3:
        assert stops == pytest.approx(oncoming_share(walking(*rest), POSE), abs=1e-5)
    assert 0.0 <= stops <= 1.0
