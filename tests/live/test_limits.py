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
from cohelm.messages import RiderProfile
from cohelm.robots import load_robot

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
    file = tmp_path / "data" / "settings.json"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


@pytest.mark.parametrize("damage", ["", "{", '{"version": 1}', '{"limits": 3, "rider": 4}'])
def test_a_file_that_does_not_read_is_refused_and_not_replaced_by_looser_limits(tmp_path, damage):
    (tmp_path / "settings.json").write_text(damage)
    with pytest.raises(StoreError, match=r"settings\.json"):
        ActiveSettings(tmp_path, ROBOT)
    assert (tmp_path / "settings.json").read_text() == damage


@pytest.fixture
def full(tmp_path, monkeypatch):
    """Settings on a disk that takes nothing until its ``undo``."""
    settings = ActiveSettings(tmp_path, ROBOT, limits=CALM)
    monkeypatch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
    return settings, monkeypatch


def test_tighter_limits_take_effect_whatever_the_disk_does_and_are_stored_later(full, tmp_path):
    settings, disk = full
    slower = Limits(max_speed=0.2, max_acceleration=0.3, min_distance=1.0)
    assert settings.set_limits(slower, moving) == CALM
    assert settings.limits == slower
    assert "full" in settings.error
    assert list(tmp_path.iterdir()) == []
    settings.retry()
    assert settings.error
    disk.undo()
    settings.retry()
    assert settings.error == ""
    assert ActiveSettings(tmp_path, ROBOT).limits == slower


def test_of_a_mixed_change_on_a_full_disk_the_tighter_part_counts(full):
    settings, _ = full
    mixed = Limits(max_speed=0.2, max_acceleration=0.6, min_distance=0.8)
    settings.set_limits(mixed, standing)
    assert settings.limits == CALM.model_copy(update={"max_speed": 0.2})


def test_looser_limits_count_only_once_they_are_stored(full, tmp_path):
    settings, disk = full
    faster = CALM.model_copy(update={"max_speed": 0.6})
    with pytest.raises(StoreError, match="cannot be written"):
        settings.set_limits(faster, standing)
    assert settings.limits == CALM
    disk.undo()
    settings.set_limits(faster, standing)
    assert ActiveSettings(tmp_path, ROBOT).limits == faster


def test_a_disk_that_hangs_delays_no_tighter_limit(tmp_path, monkeypatch):
    """The first change waits for the disk; the second one, from another thread, does not."""
    settings = ActiveSettings(tmp_path, ROBOT, limits=CALM)
    hangs, goes_on = threading.Event(), threading.Event()

    def hang(_):
        hangs.set()
        assert goes_on.wait(10.0)

    monkeypatch.setattr("os.fsync", hang)
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


def test_a_looser_change_that_waited_for_the_disk_undoes_no_tighter_one(tmp_path, monkeypatch):
    settings = ActiveSettings(tmp_path, ROBOT, limits=CALM)
    slower, faster = (CALM.model_copy(update={"max_speed": speed}) for speed in (0.2, 0.6))
    others = []

    def meanwhile(_):
        monkeypatch.undo()
        others.append(threading.Thread(target=settings.set_limits, args=(slower, moving)))
        others[0].start()
        while settings.limits != slower:
            time.sleep(0.001)

    monkeypatch.setattr("os.fsync", meanwhile)
    settings.set_limits(faster, standing)
    others[0].join()
    assert settings.limits == slower
    assert ActiveSettings(tmp_path, ROBOT).limits == slower


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
