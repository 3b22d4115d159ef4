import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.web.rate_limits import MAX_FAULT_RATE, MAX_FAULTS, RateLimit


def test_at_once_only_what_a_second_allows():
    bucket = RateLimit(60.0, 0.0)
    assert sum(bucket.take(0.0) for _ in range(1000)) == 60


@pytest.mark.parametrize("sent", [10, 59, 60])
def test_a_steady_stream_within_the_rate_is_never_refused(sent):
    bucket = RateLimit(60.0, 0.0)
    assert all(bucket.take(k / sent) for k in range(10 * sent))


@given(st.lists(st.floats(min_value=0.0, max_value=0.5), min_size=1, max_size=500))
def test_never_more_than_the_rate_and_one_burst(gaps):
    bucket, now, taken = RateLimit(100.0, 0.0), 0.0, 0
    for gap in gaps:
        now += gap
        taken += bucket.take(now)
    assert taken <= 100.0 + 100.0 * now + 1e-6


def test_a_few_faults_are_forgiven_and_many_are_not():
    faults = RateLimit(MAX_FAULT_RATE, 0.0, MAX_FAULTS)
    assert [faults.take(0.0) for _ in range(11)] == [True] * 10 + [False]
    slow = RateLimit(MAX_FAULT_RATE, 0.0, MAX_FAULTS)
    assert all(slow.take(6.0 * k) for k in range(1000))  # ten a minute
