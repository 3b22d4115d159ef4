"""The motion of a sensor from its readings alone."""

from dataclasses import replace

import numpy as np
import pytest
from tests.perception.clouds import LIDAR, cloud_of, scenery
from tests.perception.driven import corridor, furnished, walkers
from tests.perception.rays import Laser, observation, room

from cohelm.evaluation.perception.ego_motion import MatchStatus, update_ego_motion
from cohelm.geometry import compose, inverse, wrap_angle

DEGREE = np.radians(1.0)
NOTHING = np.empty((0, 3))


def drive(laser, where, seconds, discs=NOTHING, people=lambda _: NOTHING):
    """Yields (the motion so far, its error (m, rad)) after each scan, at 10 Hz."""
    way, first = None, np.asarray(where(0.0), dtype=float)
    for k in range(round(10 * seconds)):
        pose = np.asarray(where(0.1 * k), dtype=float)
        scan, _ = laser.scan(0.1 * k, pose, np.concatenate([discs, people(0.1 * k)]))
        way = update_ego_motion(way, observation(0.1 * k, scans=(scan,)))
        off = compose(inverse(compose(inverse(first), pose)), way.pose)
        yield way, (np.hypot(*off[:2]), abs(off[2]))


def ahead(time):
    return -5.0 + 0.8 * np.clip(time - 1.0, 0.0, 12.5), 0.2 * np.sin(0.5 * time), 0.0


def round_and_round(time):
    return 2.5 * np.sin(0.3 * time), 0.7 * np.sin(0.6 * time), 0.6 * np.sin(0.5 * time)


def on_the_spot(time):
    return 0.5, 0.2, wrap_angle(1.0 * time)


@pytest.mark.parametrize("people", [0, 6])
@pytest.mark.parametrize("where", [ahead, round_and_round, on_the_spot])
def test_ten_metres_are_found_to_centimetres(where, people):
    laser, discs = furnished()
    driven = list(drive(laser, where, 14.0, discs, walkers(people)))
    off = np.array([each for _, each in driven])
    assert off[:, 0].max() < 0.05
    assert off[:, 1].max() < 1.0 * DEGREE
    assert {way.status for way, _ in driven} == {MatchStatus.OK}


@pytest.mark.parametrize("noise", [0.005, 0.03])
def test_at_rest_is_exactly_at_rest_whoever_walks_there(noise):
    laser, discs = furnished(noise=noise)
    for way, _ in drive(laser, lambda _: (0.3, -0.2, 0.7), 15.0, discs, walkers(8)):
        assert not way.pose.any()
        assert not way.twist.any()
        assert way.length == 0.0


def test_people_alone_do_not_move_a_scanner_whose_walls_are_out_of_reach():
    laser, people = Laser(grid=room(10.0, 8.0), beams=720), walkers(6)
    way = None
    for k in range(100):
        scan, _ = laser.scan(0.1 * k, (0, 0, 0), people(0.1 * k))
        ranges = np.where(scan.ranges > 3.9, np.inf, scan.ranges)
        way = update_ego_motion(way, observation(0.1 * k, scans=(replace(scan, ranges=ranges),)))
        assert not way.pose.any()
    assert (way.status, way.segment) == (MatchStatus.HELD, 0)


def test_doors_tell_that_a_corridor_was_driven_along_and_smooth_walls_do_not():
    for doors, low, high in ((True, 8.5, 11.0), (False, 0.0, 0.0)):
        *_, (way, _) = drive(corridor(doors), lambda t: (-12.0 + 0.8 * t, 0.0, 0.0), 13.0)
        assert low <= way.length <= high


def test_another_place_begins_anew_and_keeps_the_pose():
    laser, discs = furnished()
    way = None
    for k in range(40):
        place = laser if k < 20 else corridor(doors=True)
        scan, _ = place.scan(0.1 * k, (0.05 * k if k < 20 else 0.0, 0.0, 0.0), discs)
        before, way = way, update_ego_motion(way, observation(0.1 * k, scans=(scan,)))
        if k == 20:
            assert (way.segment, way.status) == (1, MatchStatus.RESTARTED)
            assert (way.pose == before.pose).all()
            assert not way.twist.any()
    assert way.segment == 1


def test_after_a_gap_the_same_place_is_known_again():
    laser, discs = furnished()
    way = None
    for time, pose in ((0.0, (0, 0, 0)), (0.1, (0, 0, 0)), (40.0, (0.3, 0.2, 0.2))):
        scan, _ = laser.scan(time, pose, discs)
        way = update_ego_motion(way, observation(time, scans=(scan,)))
    assert way.segment == 0
    assert way.pose == pytest.approx([0.3, 0.2, 0.2], abs=0.02)
    assert not way.twist.any()  # nothing is known of the way between


def test_a_clock_that_stands_or_runs_back_moves_nothing():
    laser, discs = furnished()
    seen = [laser.scan(0.0, (x, 0, 0), discs)[0] for x in (0.0, 0.1, 0.2)]
    way = update_ego_motion(None, observation(10.0, scans=(seen[0],)))
    way = update_ego_motion(way, observation(10.1, scans=(seen[1],)))
    assert way.pose[0] == pytest.approx(0.1, abs=0.02)
    for when in (10.1, 9.5):
        assert update_ego_motion(way, observation(when, scans=(seen[2],))) is way
    back = update_ego_motion(way, observation(3.0, scans=(seen[2],)))
    assert (back.pose == way.pose).all()
    assert (back.status, back.segment) == (MatchStatus.RESTARTED, 0)


def test_a_cloud_tells_its_motion_as_a_scan_does():
    scene = scenery(
        (3.0, 4.0, (1.0, 0.6), 0.9), (-3.0, -2.5, (0.8, 1.6), 1.8), (2.0, -3.0, 0.2, 1.5)
    )
    way, start = None, np.array([-2.0, 0.0, 0.0])
    for k in range(40):
        pose = start + np.array([0.05, 0.02, 0.01]) * k
        cloud = cloud_of(scene, mount=LIDAR, pose=pose, seed=k)
        way = update_ego_motion(way, observation(0.1 * k, clouds=(cloud,)))
    assert way.pose == pytest.approx(pose - start, abs=0.08)
