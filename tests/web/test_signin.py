import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.web.signin import (
    LETTERS,
    MAX_SESSIONS,
    SESSION_DURATION,
    Lockout,
    SignInLocked,
    SignIns,
    WrongToken,
    new_token,
)


@pytest.fixture
def door():
    return SignIns({"driver": "abcde-fghjk", "therapist": "mnpqr-stuvw"})


def fail(door, address, now):
    with pytest.raises(WrongToken):
        door.sign_in("wrong", address, now)


def test_tokens_are_long_and_no_two_alike():
    tokens = {new_token() for _ in range(100)}
    assert len(tokens) == 100
    assert all(len(token.replace("-", "")) == 20 for token in tokens)
    assert 20 * (len(LETTERS)).bit_length() >= 96  # bits, about


@pytest.mark.parametrize("written", ["abcde-fghjk", "ABCDE FGHJK", " abcdefghjk\n"])
def test_a_token_opens_however_it_is_typed(door, written):
    cookie, session = door.sign_in(written, "a", 0.0)
    assert session.role == "driver"
    assert door.session(cookie, 1.0) is session


@pytest.mark.parametrize("written", ["", "abcde", "abcde-fghjkl", "ábcde-fghjk", "\udc80", "-"])
def test_nothing_else_opens(door, written):
    with pytest.raises(WrongToken):
        door.sign_in(written, "a", 0.0)


def test_each_role_has_its_token(door):
    assert door.sign_in("mnpqr-stuvw", "a", 0.0)[1].role == "therapist"


@pytest.mark.parametrize("cookie", [None, "", "nonsense", "\udc80"])
def test_no_session_without_its_cookie(door, cookie):
    door.sign_in("abcde-fghjk", "a", 0.0)
    assert door.session(cookie, 0.0) is None
    assert door.sign_out(cookie) is None


def test_a_session_ends_by_itself_and_by_signing_out(door):
    first, _ = door.sign_in("abcde-fghjk", "a", 0.0)
    second, session = door.sign_in("abcde-fghjk", "a", 0.0)
    assert door.sign_out(second) is session
    assert door.session(second, 1.0) is None
    assert door.session(first, SESSION_DURATION - 1.0) is not None
    assert door.session(first, SESSION_DURATION) is None


def test_sessions_are_bounded(door):
    cookies = [door.sign_in("abcde-fghjk", "a", 0.0)[0] for _ in range(MAX_SESSIONS + 1)]
    assert door.session(cookies[0], 0.0) is None
    assert door.session(cookies[1], 0.0) is not None


def test_after_failures_even_the_right_token_waits(door):
    """Three are free; then 1, 2, 4 … s."""
    for _ in range(3):
        fail(door, "a", 0.0)
    fail(door, "a", 0.0)  # 1 s from here
    with pytest.raises(SignInLocked) as locked:
        door.sign_in("abcde-fghjk", "a", 0.4)
    assert locked.value.wait == pytest.approx(0.6)
    fail(door, "a", 1.0)  # 2 s from here
    with pytest.raises(SignInLocked):
        door.sign_in("abcde-fghjk", "a", 2.9)
    door.sign_in("abcde-fghjk", "a", 3.0)
    fail(door, "a", 3.0)  # a success forgives
    fail(door, "a", 3.0)


def test_one_address_does_not_lock_another(door):
    for _ in range(4):
        fail(door, "a", 0.0)
    door.sign_in("abcde-fghjk", "b", 0.0)


def test_many_addresses_together_lock_all_that_failed_for_a_while(door):
    """30 are free in all; one more is 1 s."""
    for k in range(31):
        fail(door, f"10.0.0.{k}", 0.0)
    with pytest.raises(SignInLocked):
        door.sign_in("abcde-fghjk", "10.0.0.1", 0.5)
    door.sign_in("abcde-fghjk", "10.0.0.1", 1.0)


def test_whoever_fails_elsewhere_never_locks_out_who_has_the_token(door):
    for k in range(200):
        fail(door, f"10.0.0.{k}", 0.0)
    door.sign_in("abcde-fghjk", "10.0.1.1", 0.0)


def test_a_network_of_one_machine_counts_as_one_address(door):
    for k in range(4):
        fail(door, f"2001:db8::{k + 1:x}", 0.0)
    with pytest.raises(SignInLocked):
        door.sign_in("abcde-fghjk", "2001:db8::ffff", 0.0)
    door.sign_in("abcde-fghjk", "2001:db8:0:1::1", 0.0)


def test_what_is_remembered_of_addresses_is_bounded(door):
    for k in range(3000):
        try:
            door.sign_in("wrong", f"10.{k // 250}.0.{k % 250}", 1e4 * k)
        except WrongToken:
            continue
    assert len(door._each) <= door._MAX_ADDRESSES


@given(st.lists(st.floats(min_value=0.0, max_value=300.0), min_size=1, max_size=60))
def test_a_lock_grows_and_has_an_end(gaps):
    """Each delay is no shorter than the one before while that is remembered, nor beyond 600 s."""
    lockout, now, before = Lockout(free=3, longest=600.0), 0.0, 0.0
    for gap in gaps:
        now += gap
        lockout.failed(now)
        assert before - 1e-9 <= lockout.wait(now) <= 600.0 + 1e-9
        before = lockout.wait(now)


def test_guessing_at_full_speed_gets_nowhere():
    """An hour of trying at every chance from one address: 3 + the free one of each doubling."""
    lockout, now, tries = Lockout(free=3, longest=600.0), 0.0, 0
    while now < 3600.0:
        lockout.failed(now)
        now += max(lockout.wait(now), 1e-3)
        tries += 1
    assert tries <= 3 + 10 + 6  # 1, 2, … 512 s are ten; then one in 600 s
