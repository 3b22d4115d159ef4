import numpy as np
import pytest

from cohelm.evaluation.perception.recording_view import NO_MAP
from cohelm.perception import ScanClusters
from cohelm.testing import check_detector

from .rays import Laser, box

STILL = np.zeros(3)


def see(laser, discs=(), pose=STILL, **parameters):
    scan, told = laser.scan(0.0, pose, discs)
    detector = ScanClusters(ScanClusters.Parameters(**parameters))
    return detector.detect(scan, told, laser.walls)


def test_fulfils_the_contract():
    check_detector(ScanClusters())


@pytest.mark.parametrize("away", [1.0, 2.0, 4.0, 6.0, 8.0, 9.0])
@pytest.mark.parametrize("bearing", [0.0, 1.1, np.pi])
def test_one_person_is_one_detection_at_the_bodys_centre(away, bearing):
    person = [away * np.cos(bearing), 0.7 * away * np.sin(bearing), 0.27]
    seen = see(Laser(), person)
    assert len(seen.position) == 1
    assert np.hypot(*(seen.position[0] - person[:2])) < 0.08
    # exactly the returns that are not the room's are the person's
    on_body = np.abs(np.hypot(*(seen.points - person[:2]).T) - 0.27) < 0.06
    assert ((seen.detection_of_return == 0) == on_body).all()


def test_the_printed_centre_is_the_mean_of_the_returns():
    seen = see(Laser(), [4.0, 0.0, 0.25], centre="printed")
    assert seen.position[0] == pytest.approx(
        seen.points[seen.detection_of_return == 0].mean(axis=0)
    )
    assert 0.15 < 4.0 - seen.position[0, 0] < 0.25


@pytest.mark.parametrize("seed", range(6))
def test_an_empty_room_shows_nobody_however_badly_localised(seed):
    rng = np.random.default_rng(seed)
    laser = Laser(localisation=1.0, rng=rng)
    for _ in range(20):
        pose = rng.uniform([-8.0, -6.0, -np.pi], [8.0, 6.0, np.pi])
        seen = see(laser, pose=pose)
        assert len(seen.position) == 0
        assert seen.mapped.mean() > 0.97


@pytest.mark.parametrize("gap", [0.05, 0.3])
def test_a_person_beside_a_wall_is_seen(gap):
    # the room's upper wall has its face at 7.9 m
    seen = see(Laser(), [2.0, 7.9 - gap - 0.25, 0.25], pose=[0.0, 4.0, 0.0])
    assert len(seen.position) == 1
    assert np.hypot(*(seen.position[0] - [2.0, 7.65 - gap])) < 0.08


@pytest.mark.parametrize("away", [2.0, 4.0])
def test_two_who_touch_are_two(away):
    people = np.array([[away, -0.26, 0.25], [away, 0.26, 0.25]])
    seen = see(Laser(), people)
    assert len(seen.position) == 2
    off = np.hypot(*(seen.position[:, None] - people[None, :, :2]).transpose(2, 0, 1))
    assert off.min(axis=0).max() < 0.08


def test_without_a_map_one_scan_of_a_round_body_is_weak_evidence():
    """A bin is as round; of what a map leaves unexplained, most are people."""
    scan, told = Laser(beams=720).scan(0.0, STILL, [3.0, 0.0, 0.27])
    mapped = ScanClusters().detect(scan, told, Laser().walls).confidence.max()
    alone = ScanClusters().detect(scan, told, NO_MAP).confidence.max()
    assert mapped > 0.9
    assert alone < 0.63


def test_a_person_across_the_scans_seam_is_one():
    seen = see(Laser(), [-3.0, 0.0, 0.27])
    assert len(seen.position) == 1
    assert np.hypot(*(seen.position[0] - [-3.0, 0.0])) < 0.05


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("side", [0.5, 0.6])
def test_a_box_is_hardly_a_person(side, turn):
    for away in (1.5, 3.0, 5.0):
        seen = see(Laser(segments=box(away, 0.2, side, turn)))
        assert (seen.confidence < 0.5).all()


def test_a_long_bench_is_nobody_and_a_table_leg_must_walk_to_be_somebody():
    bench = np.array([[3.0, -2.0, 3.0, 0.5]])
    assert len(see(Laser(segments=bench)).position) == 0
    assert (see(Laser(), [2.0, 0.0, 0.04]).confidence < 0.5).all()


def test_a_body_half_hidden_by_another_is_still_one():
    # the nearer one's shadow at 4 m ends 2·0.25 = 0.5 m aside: half of the farther one shows
    people = np.array([[2.0, 0.0, 0.25], [4.0, 0.5, 0.25]])
    seen = see(Laser(), people)
    off = np.hypot(*(seen.position[:, None] - people[None, :, :2]).transpose(2, 0, 1))
    assert off.min(axis=0).max() < 0.12


@pytest.mark.parametrize("fill", [np.nan, np.inf, -np.inf, 0.0, -3.0, 1e300])
def test_a_scan_without_a_usable_return_shows_nothing(fill):
    laser = Laser()
    scan, told = laser.scan(0.0, STILL, [])
    blind = type(scan)(
        time=1.0,
        mount=scan.mount,
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        range_max=scan.range_max,
        ranges=np.full(360, fill),
    )
    seen = ScanClusters().detect(blind, told, laser.walls)
    assert len(seen.position) == len(seen.points) == 0
    assert len(seen.free_ends) == (360 if np.isposinf(fill) else 0)


def test_no_return_is_dropped():
    laser = Laser(segments=box(3.0, 2.0, 0.6), dropout=0.1)
    scan, told = laser.scan(0.0, STILL, [[2.0, -2.0, 0.25]])
    seen = ScanClusters().detect(scan, told, laser.walls)
    assert len(seen.points) == np.isfinite(scan.ranges).sum()
    assert not (seen.mapped & (seen.detection_of_return >= 0)).any()
