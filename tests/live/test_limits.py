"""Limits: tighter at any time, looser only while the chair stands, and never lost in silence."""

import stat
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.errors import StoreError
from cohelm.live.control.limits import (
    ActiveSettings,
    LimitsLoosened,
    bounded,
    defaults,
    limited_profile,
    loosened,
)
from cohelm.live.messages import Limits, RiderSettings
from cohelm.live.sessions.database import FILE, Database
from cohelm.messages import RiderProfile
from cohelm.robots import load_robot

from .disk import full_disk

ROBOT = load_robot("quantum_q6_edge")
CALM = Limits(max_speed=0.5, max_acceleration=0.4, min_distance=0.8)

some_limits = st.builds(
    Limits,
    max_speed=st.floats(0.1, 3.0),
    max_acceleration=st.floats(0.1, 2.0),
    min_distance=st.floats(0.0, 2.0),
)


def moving():
    return False


def standing():
    return True


@given(some_limits, some_limits)
def test_while_it_moves_no_change_lets_the_chair_do_more(before, after):
    settings = ActiveSettings(None, ROBOT, limits=before)
    before = settings.limits
    try:
        settings.set_limits(after, moving)
    except LimitsLoosened:
        assert loosened(before, bounded(after, ROBOT))
        assert settings.limits == before
    else:
        now = settings.limits
        assert now.max_speed <= before.max_speed
        assert now.max_acceleration <= before.max_acceleration
        assert now.min_distance >= before.min_distance


@given(some_limits, some_limits)
def test_while_it_stands_they_are_as_wanted_as_far_as_the_robot_can(before, after):
    settings = ActiveSettings(None, ROBOT, limits=before)
    settings.set_limits(after, standing)
    assert settings.limits == bounded(after, ROBOT)
    assert settings.limits.max_speed <= ROBOT.max_speed
    assert settings.limits.max_acceleration <= ROBOT.max_acceleration


def test_the_refusal_names_what_would_be_looser():
    settings = ActiveSettings(None, ROBOT, limits=CALM)
    looser = Limits(max_speed=0.6, max_acceleration=0.4, min_distance=0.5)
    with pytest.raises(LimitsLoosened, match=r"The speed .*\. The distance from people .*\."):
        settings.set_limits(looser, moving)


def test_they_outlive_the_program_and_only_the_owner_reads_them(tmp_path):
    rider = RiderSettings(tremor_filter=0.2, dead_zone=0.2, dwell=2.0)
    one = ActiveSettings(tmp_path / "data", ROBOT)
    assert one.set_limits(CALM, standing) == defaults(ROBOT, RiderProfile()).limits
    one.set_rider(rider)
    again = ActiveSettings(tmp_path / "data", ROBOT)
    assert again.limits == CALM
    assert again.rider == rider
    assert stat.S_IMODE((tmp_path / "data" / FILE).stat().st_mode) == 0o600


@pytest.mark.parametrize("damage", ["", "{", '{"version": 1}', '{"limits": 3, "rider": 4}'])
def test_settings_that_do_not_read_are_refused_and_not_replaced_by_looser_limits(tmp_path, damage):
    Database(tmp_path).set("settings", damage)
    with pytest.raises(StoreError, match=r"cohelm\.sqlite: cannot be read"):
        ActiveSettings(tmp_path, ROBOT)
    assert Database(tmp_path).setting("settings") == damage


def test_limits_of_an_older_version_are_not_replaced_by_looser_ones(tmp_path):
    (tmp_path / "settings.json").write_text("{}")
    with pytest.raises(StoreError, match=r"settings\.json: is of an older version"):
        ActiveSettings(tmp_path, ROBOT)


@pytest.fixture
def settings(tmp_path):
    return ActiveSettings(tmp_path, ROBOT, limits=CALM)


def test_tighter_limits_take_effect_whatever_the_disk_does_and_are_stored_later(settings, tmp_path):
    slower = Limits(max_speed=0.2, max_acceleration=0.3, min_distance=1.0)
    with full_disk():
        assert settings.set_limits(slower, moving) == CALM
        assert settings.limits == slower
        assert "cannot be written" in settings.error
        settings.retry()
        assert settings.error
    settings.retry()
    assert settings.error == ""
    assert ActiveSettings(tmp_path, ROBOT).limits == slower


def test_of_a_mixed_change_on_a_full_disk_the_tighter_part_counts(settings):
    mixed = Limits(max_speed=0.2, max_acceleration=0.6, min_distance=0.8)
    with full_disk():
        settings.set_limits(mixed, standing)
    assert settings.limits == CALM.model_copy(update={"max_speed": 0.2})


def test_looser_limits_count_only_once_they_are_stored(settings, tmp_path):
    faster = CALM.model_copy(update={"max_speed": 0.6})
    with full_disk(), pytest.raises(StoreError, match="cannot be written"):
        settings.set_limits(faster, standing)
    assert settings.limits == CALM
    settings.set_limits(faster, standing)
    assert ActiveSettings(tmp_path, ROBOT).limits == faster


def slow(store):
    """Let the next write wait for an event; returns that it has begun, and the event."""
    hangs, goes_on, real = threading.Event(), threading.Event(), store.set

    def hang(*given):
        hangs.set()
        assert goes_on.wait(10.0)
        real(*given)

    store.set = hang
    return hangs, goes_on


def test_a_disk_that_hangs_delays_no_tighter_limit(settings, tmp_path):
    """The first change waits for the disk; the second one, from another thread, does not."""
    hangs, goes_on = slow(settings._database)
    threads = [
        threading.Thread(
            target=settings.set_limits,
            args=(CALM.model_copy(update={"max_speed": speed}), moving),
        )
        for speed in (0.4, 0.3)
    ]
    threads[0].start()
    assert hangs.wait(10.0)
    assert settings.limits.max_speed == 0.4
    threads[1].start()
    end = time.monotonic() + 5.0
    while settings.limits.max_speed > 0.3 and time.monotonic() < end:
        time.sleep(0.01)
    assert settings.limits.max_speed == 0.3
    goes_on.set()
    for thread in threads:
        thread.join()
    assert ActiveSettings(tmp_path, ROBOT).limits.max_speed == 0.3


def test_a_looser_change_that_waited_for_the_disk_undoes_no_tighter_one(settings, tmp_path):
    slower, faster = (CALM.model_copy(update={"max_speed": speed}) for speed in (0.2, 0.6))
    hangs, goes_on = slow(settings._database)
    threads = [
        threading.Thread(target=settings.set_limits, args=given)
        for given in ((faster, standing), (slower, moving))
    ]
    threads[0].start()
    assert hangs.wait(10.0)
    threads[1].start()
    while settings.limits != slower:
        time.sleep(0.001)
    goes_on.set()
    for thread in threads:
        thread.join()
    assert settings.limits == slower
    assert ActiveSettings(tmp_path, ROBOT).limits == slower


def test_looser_limits_refused_after_they_were_stored_are_not_in_force_at_the_next_start(tmp_path):
    """The chair starts to move while the disk takes them."""
    settings = ActiveSettings(tmp_path, ROBOT, limits=CALM)
    stands = iter([True, False])
    with pytest.raises(LimitsLoosened):
        settings.set_limits(CALM.model_copy(update={"max_speed": 1.0}), lambda: next(stands))
    assert settings.limits == CALM
    assert ActiveSettings(tmp_path, ROBOT).limits == CALM


def test_the_chair_s_own_limits_are_where_they_begin():
    slow = ROBOT.model_copy(update={"max_speed": 0.6, "max_acceleration": 0.3})
    limits = defaults(slow, RiderProfile(social_distance=0.7)).limits
    assert limits == Limits(max_speed=0.6, max_acceleration=0.3, min_distance=0.7)


def test_a_request_keeps_to_the_limits_whatever_the_pace():
    rider = RiderSettings(tremor_filter=0.3, dead_zone=0.2)
    profile = limited_profile(RiderProfile(), "brisk", CALM, rider)
    assert profile.preferred_speed == 0.5
    assert profile.social_distance == 0.8
    assert (profile.tremor_filter, profile.dead_zone) == (0.3, 0.2)
    assert limited_profile(RiderProfile(), "slow", CALM, rider).preferred_speed == 0.4
