"""Whether an observation can be used: each rule at its limit and just beyond it."""

import dataclasses
import typing
from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.messages import Mode, Observation, People, PointCloud, Reason, RiderCommand, Scan
from cohelm.robots import DepthCameraMount, LidarMount
from cohelm.robots.braking import braking
from cohelm.safety import GateParameters, check_input
from cohelm.testing.scenes import walkers

from .scenes import NOW, cloud, request, scan, sound

LIMITS = GateParameters()
JUST = 1e-3
TICK = 0.05


@pytest.fixture
def check(chair):
    """(reason, memory) of an observation after ``before``, both with the default limits."""

    def call(observation, before=None, *, asked=None, robot=chair, **changes):
        parameters = GateParameters(**changes)
        asked = asked or request()
        memory = None if before is None else check_input(before, asked, robot, None, parameters)[1]
        return check_input(observation, asked, robot, memory, parameters)

    return call


def test_a_sound_observation_is_used(check):
    for mode in Mode:
        assert check(sound(), asked=request(mode))[0] is None
        assert check(sound(), sound(NOW - TICK), asked=request(mode))[0] is None


# ------------------------------------------------------------------ not a number

PEOPLE = walkers([[2.0, 0.0, 0.5, 0.1], [3.0, 1.0, 0.0, 0.0]], time=NOW, source="outside")
ALLOWED = {("scans", "ranges"), ("clouds", "points"), ("people", "heading"), ("inertial",)}
"""A range may be +inf (free) or NaN (a dropout), so may a point, a heading NaN (unknown): tested on
their own. The inertial unit, which no part uses, stops nobody."""


def numbers(kind, prefix=()):
    """(field path) of every number and every array of numbers of a value."""
    hints = typing.get_type_hints(kind)
    inner = {"scans": Scan, "clouds": PointCloud, "rider": RiderCommand, "people": People}
    for field in dataclasses.fields(kind):
        path = (*prefix, field.name)
        if field.name in inner:
            yield from numbers(inner[field.name], path)
        elif path not in ALLOWED and path != ("people", "id") and hints[field.name] is not str:
            yield path


def spoilt(observation, path, at, bad):
    """The observation with one number of the field ``path`` replaced."""
    name, *rest = path
    old = getattr(observation, name)
    if rest and isinstance(old, tuple):
        return replace(observation, **{name: (spoilt(old[0], rest, at, bad), *old[1:])})
    if rest:
        return replace(observation, **{name: spoilt(old, rest, at, bad)})
    new = np.array(old, dtype=float)
    new.flat[at] = bad
    return replace(observation, **{name: new if new.ndim else float(new)})


PATHS = list(numbers(Observation))


def test_every_field_is_meant():
    assert len(PATHS) == 8 + 5 + 3 + 2 + 5
    fields = {f.name for f in dataclasses.fields(Observation)}
    assert {path[0] for path in PATHS} == fields - {"inertial"}


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("path", PATHS, ids=".".join)
def test_a_number_that_is_none_stops_the_chair(check, path, bad):
    whole = sound(
        people=PEOPLE,
        clouds=(cloud(),),
        pose_covariance=1e-4 * np.eye(3),
        command=np.zeros(3),
    )
    for at in (0, -1):
        broken = spoilt(whole, path, at, bad)
        assert check(broken)[0] is Reason.NOT_FINITE
        assert check(broken, sound(NOW - TICK))[0] is Reason.NOT_FINITE


def test_an_observation_that_is_no_number_is_not_remembered(check):
    before = sound(NOW - TICK)
    memory = check(before)[1]
    after = check(sound(pose=np.full(3, np.nan)), before)[1]
    assert identical(memory, after)


def test_after_a_first_observation_without_numbers_the_next_good_one_counts(check):
    broken = sound(pose=np.full(3, np.nan))
    later = NOW + TICK
    assert check(sound(later), broken)[0] is None
    # but nothing was seen yet, and no time for it is granted twice
    assert check(sound(later, scans=()), broken)[0] is Reason.STALE_SCAN


def test_a_heading_may_be_unknown_but_not_infinite(check):
    unknown = replace(PEOPLE, heading=np.full(2, np.nan))
    assert check(sound(people=unknown))[0] is None
    assert check(sound(people=replace(PEOPLE, heading=[0.0, np.inf])))[0] is Reason.NOT_FINITE


@pytest.mark.parametrize(
    ("ranges", "reason"),
    [
        ([1.0, 2.0, 3.0, np.nan], None),  # a dropout
        ([1.0, 2.0, np.nan, np.nan], Reason.NOT_FINITE),  # half of them: the limit
        ([np.nan] * 4, Reason.NOT_FINITE),
        ([np.inf] * 4, None),  # nothing within reach
        ([1.0, np.inf, np.nan, np.inf], None),
        ([-np.inf] * 4, Reason.NOT_FINITE),  # something on the glass
        ([1.0, np.nan, -np.inf, 2.0], Reason.NOT_FINITE),
        ([], Reason.NOT_FINITE),
    ],
)
def test_a_scan_may_miss_beams_but_not_half_of_them(check, ranges, reason):
    assert check(sound(scans=(scan(ranges=ranges),)))[0] is reason
    assert check(sound(scans=(scan(), scan(ranges=ranges))))[0] is reason


def test_after_a_scan_of_no_numbers_nothing_counts_as_seen_until_a_good_one(chair):
    """Between two bad scans the chair does not drive on what it saw before them."""
    bad = (scan(ranges=[np.nan] * 4),)
    scans = [(scan(),), (), bad, (), bad, (), (scan(NOW + 0.3),), ()]
    none, stale = Reason.NOT_FINITE, Reason.STALE_SCAN
    memory = None
    for k, (arrived, reason) in enumerate(
        zip(scans, [None, None, none, stale, none, stale, None, None], strict=True)
    ):
        seen = sound(NOW + k * TICK, scans=arrived)
        got, memory = check_input(seen, request(), chair, memory, LIMITS)
        assert got is reason


# ------------------------------------------------------------------ too old


def aged(what, age, time=NOW):
    """``what`` was last heard ``age`` before ``time``."""
    good, then = sound(time), time - age
    if what == "scan":
        return replace(good, scans=(scan(then),))
    if what == "rider":
        return replace(good, rider=RiderCommand(heartbeat=then, deflection=np.zeros(2)))
    return replace(good, **{f"{what}_time": then})


AGES = [
    ("scan", LIMITS.scan_limit, Reason.STALE_SCAN),
    ("pose", LIMITS.pose_limit, Reason.STALE_POSE),
    ("twist", LIMITS.twist_limit, Reason.STALE_TWIST),
    ("rider", LIMITS.rider_limit, Reason.STALE_RIDER_COMMAND),
]


@pytest.mark.parametrize(("what", "limit", "reason"), AGES)
def test_at_its_limit_it_is_still_good_and_just_after_no_more(check, what, limit, reason):
    start = sound(NOW - 2.0)  # the scan is then remembered to be older than the limit
    for time in (NOW, 0.1 * 111, 3600.0 + 0.05 * 7):
        assert check(aged(what, limit, time), start)[0] is None
        assert check(aged(what, limit + JUST, time), start)[0] is reason
        assert check(aged(what, 1e6, time), start)[0] is reason


@pytest.mark.parametrize(("what", "limit", "reason"), AGES)
def test_counted_in_ticks_the_reaction_comes_within_one_of_the_limit(chair, what, limit, reason):
    """Silent from tick 40 on: what was said at tick 39 is good for limit / 0.05 ticks."""
    for first in (0, 7, 1234):
        memory, heard = None, sound((first + 39) * TICK)
        for k in range(60):
            now = (first + k) * TICK
            whole = sound(now)
            if k >= 40:
                silent = {
                    "scan": {"scans": ()},
                    "pose": {"pose_time": heard.pose_time},
                    "twist": {"twist_time": heard.twist_time},
                    "rider": {"rider": heard.rider},
                }
                whole = replace(whole, **silent[what])
            got, memory = check_input(whole, request(), chair, memory, LIMITS)
            assert got is (reason if k > 39 + round(limit / TICK) else None)


@pytest.mark.parametrize(("what", "limit", "_"), AGES)
def test_a_stamp_from_the_future_cannot_keep_a_dead_sensor_fresh(chair, what, limit, _):
    """A little ahead is two clocks that differ; more than the limit is a clock that is wrong."""
    assert check_input(aged(what, -limit), request(), chair, None, LIMITS)[0] is None
    got, memory = check_input(aged(what, -1e3), request(), chair, None, LIMITS)
    assert got is Reason.CLOCK
    later = replace(sound(NOW + 1.0), scans=())
    assert check_input(later, request(), chair, memory, LIMITS)[0] is Reason.STALE_SCAN


def test_people_from_outside_replace_the_laser(check, chair):
    blind = sound(scans=(), people=PEOPLE)
    assert check(blind, sound(NOW - 2.0))[0] is None
    no_laser = chair.model_copy(update={"lasers": ()})
    assert check(sound(scans=()), sound(NOW - 2.0), robot=no_laser)[0] is None


def test_at_first_scans_have_their_time_to_arrive(chair):
    memory = None
    for k, reason in enumerate([None] * 8 + [Reason.STALE_SCAN] * 3):  # 7 ticks make 0.35 s
        got, memory = check_input(sound(NOW + k * TICK, scans=()), request(), chair, memory, LIMITS)
        assert got is reason


# ------------------------------------------------------------------ clouds

LIDAR = LidarMount(name="lidar", pose=(-0.4, 0.0, 1.3, 0.0, 0.0, 0.0))
CAMERA = DepthCameraMount(name="depth", pose=(0.4, 0.0, 0.7, 0.0, 0.3, 0.0))


@pytest.fixture
def seer(chair):
    """A chair without a planar scanner: a LiDAR, and a depth camera."""
    return chair.model_copy(update={"lasers": (), "lidars": (LIDAR,), "depth_cameras": (CAMERA,)})


def swept(mount, time=NOW, **changes):
    return cloud(time, mount=mount.pose, **changes)


def test_a_chair_with_a_lidar_alone_drives_until_it_falls_silent(check, chair):
    robot = chair.model_copy(update={"lasers": (), "lidars": (LIDAR,)})
    before = sound(NOW - 2.0, scans=(), clouds=(swept(LIDAR, NOW - 2.0),))
    limit = LIMITS.scan_limit
    for age, reason in [(0.0, None), (limit, None), (limit + JUST, Reason.STALE_SCAN)]:
        now = sound(scans=(), clouds=(swept(LIDAR, NOW - age),))
        assert check(now, before, robot=robot)[0] is reason
    assert check(sound(scans=()), before, robot=robot)[0] is Reason.STALE_SCAN
    # what no sensor of this robot sent does not make up for it
    assert check(sound(), before, robot=robot)[0] is Reason.STALE_SCAN


@pytest.mark.parametrize("silent", [LIDAR, CAMERA])
def test_no_sensor_speaks_for_another(check, seer, silent):
    before = sound(NOW - 2.0, scans=(), clouds=(swept(LIDAR, NOW - 2.0), swept(CAMERA, NOW - 2.0)))
    both = (swept(LIDAR), swept(CAMERA))
    assert check(sound(scans=(), clouds=both), before, robot=seer)[0] is None
    other = tuple(c for c in both if c.mount[2] != silent.pose[2])
    assert check(sound(scans=(), clouds=other), before, robot=seer)[0] is Reason.STALE_SCAN


NOT_ONE = [np.nan] * 3


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        ([NOT_ONE, NOT_ONE, [1.0, 0.0, 0.0]], None),  # the sky gives nothing back
        ([[1.0, np.nan, 0.0]], Reason.NOT_FINITE),
        ([NOT_ONE] * 4, Reason.NOT_FINITE),
        ([[np.inf] * 3] * 4, Reason.NOT_FINITE),
        ([], Reason.NOT_FINITE),
    ],
)
def test_a_cloud_without_a_single_point_is_blind(check, seer, points, reason):
    clouds = (swept(LIDAR, points=points), swept(CAMERA))
    got, memory = check(sound(scans=(), clouds=clouds), robot=seer)
    assert got is reason
    later = sound(NOW + TICK, scans=(), clouds=())
    after = check_input(later, request(), seer, memory, LIMITS)[0]
    assert after is (None if reason is None else Reason.STALE_SCAN)


def test_the_height_of_a_cloud_may_be_unknown(check, seer):
    unknown = replace(swept(LIDAR), mount=[-0.4, 0.0, np.nan, 0.0, 0.0, 0.0])
    assert check(sound(scans=(), clouds=(unknown, swept(CAMERA))), robot=seer)[0] is None


def test_a_cloud_from_the_future_cannot_keep_a_dead_sensor_fresh(check, seer):
    clouds = (swept(LIDAR, NOW + 1e3), swept(CAMERA))
    assert check(sound(scans=(), clouds=clouds), robot=seer)[0] is Reason.CLOCK


# ------------------------------------------------------------------ the rider


@pytest.mark.parametrize("mode", list(Mode))
def test_no_device_is_a_fault_where_the_rider_alone_drives(check, mode):
    expected = Reason.STALE_RIDER_COMMAND if mode.rider_drives else None
    assert check(sound(rider=None), asked=request(mode))[0] is expected


@pytest.mark.parametrize("mode", list(Mode))
def test_a_device_that_fell_silent_stops_the_chair_in_every_mode(check, mode):
    silent = aged("rider", LIMITS.rider_limit + JUST)
    assert check(silent, asked=request(mode))[0] is Reason.STALE_RIDER_COMMAND


@pytest.mark.parametrize("mode", list(Mode))
def test_stop_comes_before_everything_else_that_is_wrong(check, mode):
    stopped = request(mode, stop=True)
    assert check(sound(), asked=stopped)[0] is Reason.RIDER_STOP
    assert check(sound(late=1.0, scans=()), sound(NOW - 2.0), asked=stopped)[0] is Reason.RIDER_STOP


# ------------------------------------------------------------------ clock, lateness


def test_a_clock_that_runs_back_stops_the_chair_until_it_has_caught_up(chair):
    times = [NOW, NOW - TICK, NOW - 2 * TICK, NOW, NOW + TICK]
    reasons = [None, Reason.CLOCK, Reason.CLOCK, None, None]
    memory = None
    for time, reason in zip(times, reasons, strict=True):
        got, memory = check_input(sound(time), request(), chair, memory, LIMITS)
        assert got is reason
        assert memory.time == max(time, NOW)


def test_a_tick_may_be_late_up_to_its_limit(check):
    assert check(sound(late=LIMITS.late_limit))[0] is None
    assert check(sound(late=LIMITS.late_limit + JUST))[0] is Reason.LATE


# ------------------------------------------------------------------ a pose that jumps


@pytest.mark.parametrize(
    ("speed", "turn", "elapsed", "move", "jumped"),
    [
        (0.0, 0.0, TICK, (0.24, 0.0, 0.0), False),  # jump 0.25 m
        (0.0, 0.0, TICK, (0.26, 0.0, 0.0), True),
        (0.0, 0.0, TICK, (0.0, -0.26, 0.0), True),
        (1.0, 0.0, TICK, (0.34, 0.0, 0.0), False),  # 0.25 + 2 · 1.0 · 0.05 = 0.35 m
        (1.0, 0.0, TICK, (0.36, 0.0, 0.0), True),
        (1.0, 0.0, 0.25, (0.74, 0.0, 0.0), False),  # 0.25 + 2 · 1.0 · 0.25 = 0.75 m
        (1.0, 0.0, 0.25, (0.76, 0.0, 0.0), True),
        (0.0, 0.0, TICK, (0.0, 0.0, 0.34), False),  # jump_angle 0.35
        (0.0, 0.0, TICK, (0.0, 0.0, 0.36), True),
        (0.0, 1.0, TICK, (0.0, 0.0, -0.44), False),  # 0.35 + 2 · 1.0 · 0.05 = 0.45
        (0.0, 1.0, TICK, (0.0, 0.0, -0.46), True),
    ],
)
def test_a_pose_may_change_as_speed_and_time_explain(check, speed, turn, elapsed, move, jumped):
    here = np.array([4.0, 3.0, 3.1])  # a heading that wraps on the way
    twist = np.array([speed, 0.0, turn])
    before = sound(NOW - elapsed, pose=here, twist=twist)
    there = here + move
    there[2] = np.remainder(there[2] + np.pi, 2 * np.pi) - np.pi
    got = check(sound(pose=there, twist=twist), before)[0]
    assert got is (Reason.POSE_JUMP if jumped else None)


def test_after_a_jump_the_chair_stands_for_a_while_and_then_believes_the_new_pose(chair):
    # jump_hold 0.5 s: 10 ticks, the one of the jump included
    memory, reasons = None, []
    for k in range(25):
        pose = np.array([1.0 if k >= 5 else 0.0, 0.0, 0.0])
        got, memory = check_input(
            sound(NOW + k * TICK, pose=pose), request(), chair, memory, LIMITS
        )
        reasons.append(got)
    assert reasons == [None] * 5 + [Reason.POSE_JUMP] * 10 + [None] * 10


def test_a_pose_that_keeps_jumping_keeps_the_chair_standing(chair):
    memory = check_input(sound(), request(), chair, None, LIMITS)[1]
    for k in range(1, 40):
        pose = np.array([float(k % 2), 0.0, 0.0])
        got, memory = check_input(
            sound(NOW + k * TICK, pose=pose), request(), chair, memory, LIMITS
        )
        assert got is Reason.POSE_JUMP


# ------------------------------------------------------------------ odometry that cannot be


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_twist_beyond_five_times_what_the_chair_can_do_tells_nothing(chair, check, which, sign):
    most = 5.0 * np.array([chair.max_speed, chair.max_speed, chair.max_turn_rate])
    for size, reason in (
        (most[which] * (1.0 - JUST), None),
        (most[which] * (1.0 + JUST), Reason.STALE_TWIST),
        (1e6, Reason.STALE_TWIST),
        (1e308, Reason.STALE_TWIST),
    ):
        twist = np.zeros(3)
        twist[which] = sign * size
        assert check(sound(twist=twist))[0] is reason
        assert check(sound(twist=twist), sound(NOW - TICK))[0] is reason


def test_a_twist_that_cannot_be_excuses_no_jump(chair):
    """5 · 1.2 m/s explain 2 · 6 · 0.05 + 0.25 = 0.85 m in a tick, whatever odometry says."""
    memory = check_input(sound(NOW - TICK), request(), chair, None, LIMITS)[1]
    for moved, held in ((0.84, False), (0.86, True)):
        wild = sound(pose=np.array([moved, 0.0, 0.0]), twist=np.array([1e6, 0.0, 0.0]))
        after = check_input(wild, request(), chair, memory, LIMITS)[1]
        assert (after.held_until > NOW) is held


def test_when_odometry_is_right_again_the_ride_goes_on(chair):
    memory, reasons = None, []
    for k in range(6):
        twist = np.array([1e6 if k in {2, 3} else 0.5, 0.0, 0.0])
        got, memory = check_input(
            sound(NOW + k * TICK, twist=twist), request(), chair, memory, LIMITS
        )
        reasons.append(got)
    assert reasons == [None] * 2 + [Reason.STALE_TWIST] * 2 + [None] * 2


def test_braking_from_what_is_believed_is_looked_at_in_a_few_hundred_poses(chair):
    """From 6 m/s or 6 rad/s the slower of the two needs some seconds, in steps of 50 ms."""
    fastest = 5.0 * np.array([chair.max_speed, chair.max_turn_rate])
    poses = braking(
        chair, np.zeros(3), fastest, np.zeros(2),
        hold=LIMITS.reaction, deceleration=chair.max_deceleration, step=0.05,
    )  # fmt: skip
    assert len(poses) < 400


# ------------------------------------------------------------------ in general


def test_nothing_it_is_given_changes_and_the_same_is_answered_twice(chair):
    memory = check_input(sound(), request(), chair, None, LIMITS)[1]
    observation = sound(NOW + TICK, speed=0.5)
    one = check_input(observation, request(), chair, memory, LIMITS)
    two = check_input(observation, request(), chair, memory, LIMITS)
    assert identical(one, two)
    assert memory.time == NOW
