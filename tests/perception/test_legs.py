"""People by their legs, and furniture that stands on as many."""

import dataclasses
import itertools
import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.evaluation.perception.recording_view import NO_MAP, parts_of
from cohelm.messages import Scan
from cohelm.perception import PerceptionParts, ScanClusters, perceive
from cohelm.perception.change_detection.past_scans import PastScan, remember_scan
from cohelm.perception.change_detection.scan_changes import detect_changes
from cohelm.perception.scan_detection.legs import (
    MAX_LOG_ODDS,
    pair_legs,
    stride_log_odds,
    width_log_odds,
)
from cohelm.recordings import open_recording
from cohelm.testing.scenes import scan_of

from .rays import Laser, box, observation

LEG = 0.06
STILL = (0.0, 0.0, 0.0)


def legs_of(x, y, apart=0.25, heading=0.0, radius=LEG):
    """Two legs, one before the other."""
    aside = 0.5 * apart * np.array([np.cos(heading), np.sin(heading)])
    return np.array([[x + aside[0], y + aside[1], radius], [x - aside[0], y - aside[1], radius]])


def chair(x, y, turn, radius=0.02):
    corner = turn + np.pi / 4 + np.pi / 2 * np.arange(4)
    return np.stack(
        [x + 0.28 * np.cos(corner), y + 0.28 * np.sin(corner), np.full(4, radius)], axis=-1
    )


def parts():
    return PerceptionParts(**parts_of([]))


def watch(laser, discs_at, seconds, where=lambda _: STILL, rate=10.0, mapped=True):
    """(time, people, detections) of each scan, through the whole pipeline."""
    memory, all_parts = None, parts()
    for k in range(round(seconds * rate)):
        now = k / rate
        scan, told = laser.scan(now, where(now), discs_at(now))
        walls = laser.walls if mapped else NO_MAP
        perceived, memory = perceive(
            all_parts, observation(now, told, scans=(scan,)), walls, memory
        )
        yield now, perceived.people, perceived.detections[0]


def furnished(seed):
    """Discs and segments of a room of chairs, tables, bins, boxes, pillars and door posts."""
    rng = np.random.default_rng(seed)

    def place():
        # farther away a bin has as few returns as a person
        return rng.uniform(-4.0, 4.0), rng.choice([-1.0, 1.0]) * rng.uniform(1.5, 3.5)

    discs = [chair(*place(), rng.uniform(0, 6), rng.choice([0.012, 0.02])) for _ in range(8)]
    for _ in range(3):
        x, y = place()
        discs += [[[x + a, y + b, 0.03]] for a, b in itertools.product((-0.7, 0.7), (-0.4, 0.4))]
    discs += [[[*place(), rng.uniform(0.12, 0.16)]] for _ in range(3)]
    segments = [box(*place(), rng.uniform(0.3, 0.7), rng.uniform(0, 2)) for _ in range(5)]
    for _ in range(2):
        x, y = place()
        segments += [box(x, y, 0.1), box(x, y + 0.9, 0.1)]
    return np.concatenate(discs), np.concatenate(segments)


def test_a_leg_is_sooner_as_wide_as_a_leg_than_as_a_chairs_or_a_box():
    odds = [width_log_odds(w, 0.01, 0.12, 0.04) for w in (0.03, 0.12, 0.35)]
    assert odds[1] > 1.0 > -1.0 > max(odds[0], odds[2])
    # at its peak: 3.4 · 0.12 / (0.0403 √(2π))
    assert odds[1] == pytest.approx(np.log(3.4 * 0.12 / (0.0403 * np.sqrt(2 * np.pi))), abs=0.01)


def test_a_stride_is_short_and_chance_is_not():
    assert stride_log_odds(0.2, 0.8) > 0.0 > stride_log_odds(0.75, 0.8)
    # where the densities agree: ln(2.5² / 2) = d² / 2m², with the mode m = 0.8 / 2.5
    even = 0.8 / 2.5 * np.sqrt(2 * np.log(3.125))
    assert stride_log_odds(even, 0.8) == pytest.approx(0.0, abs=1e-9)


def test_the_nearest_legs_walk_together_and_each_leg_once():
    centre = np.array([[0.0, 0.0], [0.2, 0.0], [0.65, 0.0], [3.0, 0.0]])
    pairs, odds = pair_legs(centre, np.full(4, 1.0), 0.8, -1.0)
    assert sorted(map(tuple, pairs.tolist())) == [(0, 1), (2, -1), (3, -1)]
    assert (odds <= MAX_LOG_ODDS).all()
    assert odds[0] > odds[1] == odds[2]


def test_nobody_has_no_legs():
    pairs, odds = pair_legs(np.empty((0, 2)), np.empty(0), 0.8, -1.0)
    assert len(pairs) == len(odds) == 0


@pytest.mark.parametrize("away", [1.0, 2.5, 4.0])
@pytest.mark.parametrize("heading", [0.0, 0.8, np.pi / 2])
@pytest.mark.parametrize("apart", [0.15, 0.3, 0.6])
def test_legs_within_a_stride_are_one_person(away, heading, apart):
    scan, told = Laser(beams=1028).scan(0.0, STILL, legs_of(away, 0.4, apart, heading))
    seen = ScanClusters().detect(scan, told, Laser().walls)
    off = np.hypot(*(seen.position - [away, 0.4]).T)
    # one leg may hide the other: then its own centre is half a stride away
    assert len(off) == 1
    assert off[0] < 0.5 * apart + 0.08
    assert seen.confidence[0] > 0.25


@pytest.mark.parametrize("away", [2.0, 3.5])
@pytest.mark.parametrize("beams", [720, 1028])
def test_who_walks_in_on_two_legs_is_told_as_one_person(away, beams):
    def walker(t):
        # 1.1 m/s, a step of 0.6 s
        return legs_of(away, -3.0 + 1.1 * t, 0.5 * np.sin(np.pi * t / 0.6), np.pi / 2)

    told = list(watch(Laser(beams=beams), walker, 5.0, mapped=False))
    late = [(now, people) for now, people, _ in told if now > 1.0]
    assert np.mean([len(people) == 1 for _, people in late]) > 0.9
    errors = [
        np.hypot(*(people.mean[0, :2] - [away, -3.0 + 1.1 * now]))
        for now, people in late
        if len(people)
    ]
    assert np.mean(errors) < 0.2


def test_who_walks_in_and_stands_stays_told():
    def stops(t):
        return legs_of(2.5, -2.0 + min(1.1 * t, 2.0), 0.2, np.pi / 2)

    told = [len(p) for now, p, _ in watch(Laser(beams=720), stops, 12.0) if now > 2.0]
    assert np.mean(np.array(told) >= 1) > 0.95


@pytest.mark.parametrize("beams", [720, 1028])
@pytest.mark.parametrize("seed", range(3))
def test_furniture_seen_from_one_place_is_nobody(seed, beams):
    discs, segments = furnished(seed)
    laser = Laser(segments=segments, beams=beams, rng=np.random.default_rng(seed))
    told = [len(people) for _, people, _ in watch(laser, lambda _: discs, 4.0, mapped=False)]
    assert np.mean(told) < 0.1


def test_a_place_that_was_empty_and_is_not_says_that_something_came():
    laser = Laser(beams=720)
    leg = [[2.0, 0.0, LEG]]
    past, verdicts = (), []
    for k in range(90):
        scan, told = laser.scan(k / 10, STILL, leg if k >= 40 else [])
        seen = detect_changes(ScanClusters().detect(scan, told, laser.walls), past)
        past = remember_scan(past, scan, told)
        verdicts += list(seen.arrival_log_odds) if k >= 40 else []
    # new for 1.5 s, then at rest, but never furniture
    assert verdicts[0] == 3.0
    assert min(verdicts[:15]) > 2.0
    assert verdicts[-1] == 0.0


def test_what_was_always_there_is_at_rest():
    laser = Laser(beams=720)
    past = ()
    for k in range(80):
        scan, told = laser.scan(k / 10, STILL, [[2.0, 0.0, LEG]])
        seen = detect_changes(ScanClusters().detect(scan, told, laser.walls), past)
        past = remember_scan(past, scan, told)
    assert seen.arrival_log_odds == pytest.approx([-2.0])


def test_memory_grows_with_the_logarithm_of_time():
    scan = Scan(
        time=0.0,
        mount=np.zeros(3),
        angle_min=-np.pi,
        angle_increment=0.1,
        range_max=10.0,
        ranges=np.full(63, 3.0),
    )
    past = ()
    for k in range(3000):
        past = remember_scan(past, type(scan)(**{**_fields(scan), "time": k / 10}), np.zeros(3))
    ages = [299.9 - g.scan.time for g in past]
    assert ages == sorted(ages)
    # at most two for each factor of 1.25 between 0.2 and 300 s
    assert len(past) <= 2 * np.log(1500) / np.log(1.25)
    assert max(ages) > 150.0


def _fields(scan):
    return {name: getattr(scan, name) for name in type(scan).__slots__}


def test_a_clock_that_runs_back_forgets_and_a_blind_pose_is_not_kept():
    scan, _ = Laser().scan(5.0, STILL, [])
    early, _ = Laser().scan(1.0, STILL, [])
    past = remember_scan((), scan, np.zeros(3))
    assert isinstance(past[0], PastScan)
    assert [g.scan.time for g in remember_scan(past, early, np.zeros(3))] == [1.0]
    assert remember_scan(past, scan, np.full(3, np.nan)) is past


@pytest.mark.data
@pytest.mark.parametrize("number", [1, 2])
def test_labelled_legs_are_told(number):
    data = os.environ.get("COHELM_DATA")
    path = Path(data or "") / "lidar" / f"legtracker_positive_{number}_extracted.bag"
    if not data or not path.is_file():
        pytest.skip("COHELM_DATA names no folder with lidar/legtracker_positive_*_extracted.bag")
    memory, all_parts, found, strange = None, parts(), [], []
    for frame in open_recording(path):
        perceived, memory = perceive(all_parts, frame.observation, NO_MAP, memory)
        if frame.labels is None:
            continue
        off = frame.labels.position[:, None] - perceived.people.mean[None, :, :2]
        near = np.hypot(off[..., 0], off[..., 1]) <= 0.5
        found += near.any(axis=1).tolist()
        strange.append(int((~near.any(axis=0)).sum()))
    assert np.mean(found) >= 0.95
    assert np.mean(strange) <= 1.0


def test_where_a_full_turn_begins_changes_nothing():
    """Two legs, an end of one behind a thin post: the scan's seam may lie on any of them."""
    X_MR = np.array([4.0, 4.0, 0.0])
    discs = X_MR + np.array([[2.0, 0.15, 0.06], [2.0, -0.15, 0.06], [0.99, -0.12, 0.03]])
    scan = scan_of(pose=X_MR, discs=discs)
    detector, turns = ScanClusters(), range(330, 390)
    told = []
    for turn in (0, *turns):
        turned = dataclasses.replace(
            scan,
            angle_min=scan.angle_min + turn * scan.angle_increment,
            ranges=np.roll(scan.ranges, -turn),
        )
        seen = detector.detect(turned, X_MR, NO_MAP)
        perhaps = seen.confidence > 0.1  # of a wall all round it matters where it is cut
        found = np.column_stack([seen.position, seen.confidence])[perhaps]
        told.append(found[np.lexsort(found.T)])
    assert len(told[0]) == 2  # the post may be a leg, too
    for other in told[1:]:
        assert other[:, :2] == pytest.approx(told[0][:, :2], abs=1e-9)
        # Pieces of the wall, which the seam cuts, count as surroundings.
        assert other[:, 2] == pytest.approx(told[0][:, 2], abs=0.1)
