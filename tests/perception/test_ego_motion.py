"""The way of a sensor from its readings alone."""

import time
from dataclasses import replace

import numpy as np
import pytest

from cohelm.geometry import wrap_angle
from cohelm.perception import EgoMotionParameters, MatchStatus, update_ego_motion
from cohelm.perception.laser_odometry.scan_features import (
    ScanFeatures,
    features_of_cloud,
    features_of_scan,
)

from .clouds import LIDAR, cloud_of, scenery
from .driven import corridor, drive, errors, furnished, walkers
from .rays import Laser, room

DEGREE = np.radians(1.0)


def ahead(time):
    return -5.0 + 0.8 * np.clip(time - 1.0, 0.0, 12.5), 0.2 * np.sin(0.5 * time), 0.0


def round_and_round(time):
    return 2.5 * np.sin(0.3 * time), 0.7 * np.sin(0.6 * time), 0.6 * np.sin(0.5 * time)


@pytest.mark.parametrize("people", [0, 6])
@pytest.mark.parametrize("where", [ahead, round_and_round])
def test_ten_metres_of_way_are_found_to_centimetres(where, people):
    laser, discs = furnished()
    driven = list(drive(laser, where, 14.0, discs, walkers(people)))
    off = errors(driven)
    assert off[:, 0].max() < 0.03
    assert off[:, 1].max() < 0.2 * DEGREE
    assert {way.status for way, _ in driven} == {MatchStatus.OK}
    assert driven[-1][0].length > 8.0


def test_turning_on_the_spot():
    laser, discs = furnished(beams=360)
    off = errors(drive(laser, lambda t: (0.5, 0.2, wrap_angle(1.0 * t)), 13.0, discs, walkers(4)))
    assert off[:, 0].max() < 0.02
    assert off[:, 1].max() < 0.3 * DEGREE


@pytest.mark.parametrize("noise", [0.005, 0.03])
def test_at_rest_is_exactly_at_rest_whoever_walks_there(noise):
    laser, discs = furnished(noise=noise)
    for way, _ in drive(laser, lambda _: (0.3, -0.2, 0.7), 15.0, discs, walkers(8)):
        assert (way.pose == 0.0).all()
        assert (way.twist == 0.0).all()
        assert way.length == 0.0


def test_at_rest_is_at_rest_though_walkers_hide_most_of_a_short_view():
    for seed in range(3):
        laser, discs = furnished(noise=0.02, seed=seed)
        way, people = None, walkers(9, seed)
        for k in range(100):
            scan, _ = laser.scan(0.1 * k, (0, 0, 0.3), np.concatenate([discs, people(0.1 * k)]))
            ranges = scan.ranges.copy()
            ranges[:180] = ranges[-180:] = np.nan  # looks ahead
            ranges[ranges > 4.5] = np.inf
            scan = replace(scan, ranges=ranges, range_max=4.5)
            way = update_ego_motion(way, features_of_scan(scan), scan.time)
            assert (way.pose == 0.0).all()


def strollers(count, seed):
    """Bodies of so many people who stroll to and fro, at each time."""
    rng = np.random.default_rng(seed)
    middle, course = rng.uniform(-2.5, 2.5, (count, 2)), rng.uniform(0.0, 2.0 * np.pi, count)
    along = np.column_stack([np.cos(course), np.sin(course)])

    def at(time):
        gone = 2.0 * np.sin(0.5 * time + course)[:, None]
        return np.column_stack([middle + gone * along, np.full(count, 0.18)])

    return at


@pytest.mark.parametrize("reach", [2.5, 4.05, 4.2, 4.6])
@pytest.mark.parametrize("count", [1, 2, 6])
def test_people_alone_do_not_move_a_scanner_whose_walls_are_out_of_reach(reach, count):
    laser = Laser(grid=room(10.0, 8.0), beams=720, rng=np.random.default_rng(3))
    way, people, said = None, strollers(count, 2), set()
    for k in range(100):
        scan, _ = laser.scan(0.1 * k, (0, 0, 0), people(0.1 * k))
        ranges = np.where(scan.ranges > reach, np.inf, scan.ranges)
        scan = replace(scan, ranges=ranges, range_max=reach)
        way = update_ego_motion(way, features_of_scan(scan), scan.time)
        said.add(way.status)
        assert (way.pose == 0.0).all()
    assert way.segment == 0
    assert said & {MatchStatus.PARTIAL, MatchStatus.HELD}  # nothing shows that it rests


def test_pillars_alone_show_that_a_scanner_drives():
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(-8.0, 9.0, 2.0), np.arange(-6.0, 7.0, 3.0))
    places = np.column_stack([x.ravel(), y.ravel()]) + rng.uniform(-0.3, 0.3, (x.size, 2))
    laser = Laser(grid=room(40.0, 40.0), beams=720, rng=rng)
    pillars = np.column_stack([places, np.full(x.size, 0.2)])
    off = errors(drive(laser, lambda t: (-4.0 + 0.5 * t, 0.9, 0.1 * t), 12.0, pillars))
    assert off[:, 0].max() < 0.06  # the first 5 cm are driven before it is sure
    assert off[-1, 0] < 0.03


def test_who_stops_rests_where_it_stopped():
    laser, discs = furnished()
    driven = list(drive(laser, lambda t: (-3.0 + 0.5 * min(t, 6.0), 0.0, 0.0), 12.0, discs))
    assert not driven[40][0].resting
    last = [way for way, _ in driven[-40:]]
    assert all(way.resting for way in last)
    assert len({tuple(way.pose) for way in last}) == 1
    assert errors(driven)[-1, 0] < 0.02


def test_who_creeps_is_never_far_from_where_it_is_said_to_be():
    laser, discs = furnished()
    off = errors(drive(laser, lambda t: (0.02 * t, 0.0, 0.0), 20.0, discs))
    # told to have moved from 2 cm on, by the second scan that says so at the latest
    assert off[:, 0].max() < EgoMotionParameters().min_shift + 0.01


def test_the_twist_is_that_of_the_robot():
    laser, discs = furnished()
    turning, speed = 0.4, 0.6

    def circle(t):
        return 1.5 * np.sin(turning * t), -1.5 * np.cos(turning * t), wrap_angle(turning * t)

    twists = [way.twist for way, _ in drive(laser, circle, 8.0, discs)][5:]
    assert np.mean(twists, axis=0) == pytest.approx([speed, 0.0, turning], abs=0.01)


@pytest.mark.parametrize("people", [False, True])
def test_doors_tell_how_far_a_corridor_was_driven_along(people):
    def beside(t):  # one who goes along, one who comes
        return np.array([[-11.0 + 0.9 * t, 0.5, 0.08], [8.0 - t, -0.5, 0.08]])[: 2 * people]

    off = errors(drive(corridor(doors=True), lambda t: (-12 + 0.8 * t, 0, 0), 13.0, people=beside))
    assert off[:, 0].max() < 0.1  # of 10 m
    assert off[:, 1].max() < 0.3 * DEGREE


def test_a_smooth_corridor_says_so_and_invents_nothing():
    laser = corridor(doors=False)

    def passing(t):
        return np.array([[-4.0 + 0.9 * t, 0.5, 0.08], [4.0 - t, -0.5, 0.08]])

    driven = list(drive(laser, lambda _: (0.0, 0.0, 0.0), 8.0, people=passing))
    assert {way.status for way, _ in driven[1:]} == {MatchStatus.PARTIAL}
    assert not errors(driven).any()


def test_another_place_begins_anew_and_keeps_the_pose():
    laser, discs = furnished()
    other = corridor(doors=True)
    way = None
    for k in range(40):
        place = laser if k < 20 else other
        scan, _ = place.scan(0.1 * k, (0.05 * k if k < 20 else 0.0, 0.0, 0.0), discs)
        before, way = way, update_ego_motion(way, features_of_scan(scan), 0.1 * k)
        if k == 20:
            assert (way.segment, way.status) == (1, MatchStatus.RESTARTED)
            assert (way.pose == before.pose).all()
            assert (way.twist == 0.0).all()
    assert way.segment == 1
    assert way.resting


def test_after_a_gap_the_same_place_is_known_again():
    laser, discs = furnished()
    scans = [laser.scan(t, (0.0, 0.0, 0.0), discs)[0] for t in (0.0, 0.1, 16.0)]
    scans.append(laser.scan(40.0, (0.6, 0.3, 0.2), discs)[0])
    way = None
    for scan in scans:
        way = update_ego_motion(way, features_of_scan(scan), scan.time)
        if scan.time < 20.0:
            assert (way.pose == 0.0).all()
    assert way.segment == 0
    assert way.pose == pytest.approx([0.6, 0.3, 0.2], abs=0.02)
    assert (way.twist == 0.0).all()  # nobody knows how it went meanwhile


def test_a_covered_view_is_held_out_for_a_moment():
    laser, discs = furnished()
    way, said = None, []
    for k in range(40):
        around = [[0.45 * np.cos(a), 0.45 * np.sin(a), 0.25] for a in np.arange(6) * np.pi / 3]
        scan, _ = laser.scan(0.1 * k, (0, 0, 0), discs if not 10 <= k < 15 else np.array(around))
        way = update_ego_motion(way, features_of_scan(scan), 0.1 * k)
        said.append(way.status)
        assert (way.pose == 0.0).all()
    assert set(said[10:15]) == {MatchStatus.HELD}
    assert set(said[:10] + said[15:]) == {MatchStatus.OK}


def test_too_few_returns_say_nothing_for_ever():
    nothing = ScanFeatures(points=np.empty((0, 2)), normals=np.empty((0, 2)))
    way = None
    for k in range(30):
        way = update_ego_motion(way, nothing, float(k))
    assert (way.status, way.segment) == (MatchStatus.HELD, 0)
    assert (way.pose == 0.0).all()


def test_a_clock_that_stands_or_runs_back_moves_nobody():
    laser, discs = furnished()
    outlines = [features_of_scan(laser.scan(0.0, (x, 0, 0), discs)[0]) for x in (0.0, 0.1, 0.2)]
    way = update_ego_motion(update_ego_motion(None, outlines[0], 10.0), outlines[1], 10.1)
    assert way.pose[0] == pytest.approx(0.1, abs=0.01)
    for when in (10.1, 9.5, np.nan):
        assert update_ego_motion(way, outlines[2], when) is way
    back = update_ego_motion(way, outlines[2], 3.0)
    assert (back.pose == way.pose).all()
    assert (back.status, back.segment, back.resting) == (MatchStatus.RESTARTED, 0, True)


def test_a_way_is_a_value():
    laser, discs = furnished(beams=360)
    (first, _), (second, _), *_ = drive(laser, lambda t: (t, 0.0, 0.0), 0.3, discs)
    outline = features_of_scan(laser.scan(0.2, (0.2, 0.0, 0.0), discs)[0])
    once, twice = (update_ego_motion(second, outline, 0.2) for _ in range(2))
    assert (once.pose == twice.pose).all()
    assert (first.pose == 0.0).all()


def test_a_cloud_tells_its_way_as_a_scan_does():
    way, off = None, []
    scene = scenery(
        (3.0, 4.0, (1.0, 0.6), 0.9), (-3.0, -2.5, (0.8, 1.6), 1.8), (2.0, -3.0, 0.2, 1.5)
    )
    for k in range(40):
        pose = np.array([-2.0 + 0.05 * k, 0.02 * k, 0.01 * k])
        observation = features_of_cloud(cloud_of(scene, mount=LIDAR, pose=pose, seed=k))
        way = update_ego_motion(way, observation, 0.1 * k)
        first = np.array([-2.0, 0.0, 0.0])
        off.append(np.hypot(*(way.pose - (pose - first))[:2]))
    assert max(off) < 0.05
    assert way.pose[2] == pytest.approx(0.39, abs=0.5 * DEGREE)


@pytest.mark.slow
def test_a_scan_is_matched_within_three_milliseconds():
    laser, discs = furnished()
    scans = [laser.scan(0.1 * k, ahead(0.1 * k), discs)[0] for k in range(60)]
    way, cost = None, []
    for scan in scans:
        begin = time.thread_time()
        way = update_ego_motion(way, features_of_scan(scan), scan.time)
        cost.append(time.thread_time() - begin)
    assert np.median(cost[5:]) < 3e-3
