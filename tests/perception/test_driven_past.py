"""What a chair tells of furniture that it drives past, and of people who stand beside its way."""

import numpy as np
import pytest
from tests.perception.rays import Laser, box, observation, room

from cohelm.maps import OccupancyGrid, distance_field
from cohelm.perception import KalmanTracker, PerceptionParts, ScanClusters, perceive
from cohelm.perception.cloud_detection.cloud_clusters import CloudClusters
from cohelm.perception.groups.affinity import NoGroups

NO_MAP = distance_field(
    OccupancyGrid(
        data=np.zeros((4, 4), dtype=np.int8), resolution=10.0, X_MG=np.array([-20.0, -20.0, 0.0])
    )
)
STANDING = np.array([[-1.0, 1.3, 0.25], [1.5, -1.2, 0.27], [3.0, 1.4, 0.24]])
"""(x, y, radius) of three people beside the way, m."""


def four_legs(x, y, angle, length, width, radius):
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * [length / 2, width / 2]
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([corners @ np.array([[c, s], [-s, c]]) + [x, y], np.full(4, radius)])


def furniture(rng):
    """Chairs, tables, bins, lamps (discs) and boxes, pillars, posts (segments) beside the way."""

    def spot():
        return rng.uniform(-8.0, 8.0), rng.choice([-1.0, 1.0]) * rng.uniform(1.2, 6.5)

    turn = rng.uniform(0.0, 6.0, 11)
    thick = rng.choice([0.012, 0.02, 0.03, 0.05], 11)
    discs = [four_legs(*spot(), turn[k], 0.4, 0.4, thick[k]) for k in range(8)]
    discs += [four_legs(*spot(), turn[k], 1.4, 0.75, thick[k]) for k in range(8, 11)]
    discs += [[[*spot(), rng.uniform(0.12, 0.18)]] for _ in range(3)]
    discs += [[[*spot(), 0.035]] for _ in range(3)]
    sides = [*rng.uniform(0.25, 0.7, 5), 0.1, 0.1]
    segments = [box(*spot(), side, rng.uniform(0.0, 2.0)) for side in sides]
    return np.concatenate(discs), np.concatenate(segments)


def told(laser, walls, discs, *, speed, seconds):
    """The people told after each scan at 10 Hz by a chair that winds its way along the room."""
    parts = PerceptionParts(
        detector=ScanClusters(),
        cloud_detector=CloudClusters(),
        tracker=KalmanTracker(),
        group_detector=NoGroups(),
    )
    memory = None
    for k in range(round(10 * seconds)):
        t = k / 10
        way = speed / 0.8
        pose = [-7.0 * way + speed * t, 0.4 * way * np.sin(0.4 * t), 0.4 * way * np.sin(0.6 * t)]
        scan, known = laser.scan(t, pose, discs)
        seen, memory = perceive(parts, observation(t, known, scans=(scan,)), walls, memory)
        yield t, seen.people


@pytest.mark.parametrize("beams", [360, 720])
@pytest.mark.parametrize("speed", [0.0, 0.8])
@pytest.mark.parametrize("mapped", [True, False])
def test_nobody_is_told_among_furniture(beams, speed, mapped):
    for seed in (7, 8):
        rng = np.random.default_rng([seed, beams])
        discs, segments = furniture(rng)
        laser = Laser(
            grid=room(), segments=segments, beams=beams, localisation=float(speed > 0.0), rng=rng
        )
        walls = laser.walls if mapped else NO_MAP
        counts = [
            len(who)
            for _, who in told(
                laser, walls, discs, speed=speed, seconds=7.0 if speed == 0.0 else 10.0
            )
        ]
        # With a map the fit of a disc decides: a table leg may pass for a person for a second.
        assert sum(counts) <= (10 if mapped and speed else 0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("driven", "walked"), [(0.1, 0.4), (0.1, -0.4), (0.1, 0.6), (0.2, 0.5), (0.2, 0.6), (0.2, -0.5)]
)
def test_who_walks_slowly_is_told_by_a_scanner_that_drives_without_a_map(driven, walked, side):
    laser = Laser(grid=room(10.0, 8.0), beams=720, rng=np.random.default_rng(1))
    parts = PerceptionParts(
        detector=ScanClusters(),
        cloud_detector=CloudClusters(),
        tracker=KalmanTracker(),
        group_detector=NoGroups(),
    )
    memory, found = None, []
    for k in range(70):
        t = k / 10
        body = np.array([[walked * (t - 3.5), 1.5 * side, 0.18]])
        scan, pose = laser.scan(t, [driven * t, 0.0, 0.0], body)
        seen, memory = perceive(parts, observation(t, pose, scans=(scan,)), NO_MAP, memory)
        apart = np.hypot(*(seen.people.mean[:, :2] - body[0, :2]).T)
        found.append(apart.min(initial=9.0) < 0.3)
        assert (apart < 0.3).all()
    # 0.8 m of way, see walked_distance and parallax, and a second of pace.
    assert all(found[10 + round(8.0 / abs(walked)) :])


@pytest.mark.parametrize("seed", [1, 2])
def test_who_stands_beside_the_way_is_told_while_the_chair_passes_and_keeps_the_id(seed):
    laser = Laser(grid=room(), beams=720, localisation=1.0, rng=np.random.default_rng(seed))
    ids = [set() for _ in STANDING]
    for t, people in told(laser, laser.walls, STANDING, speed=0.8, seconds=15.0):
        apart = np.hypot(*(STANDING[:, None, :2] - people.mean[None, :, :2]).transpose(2, 0, 1))
        chair = -7.0 + 0.8 * t
        for k in np.flatnonzero(np.abs(STANDING[:, 0] - chair) < 3.0):
            assert apart[k].min(initial=9.0) < 0.15
            ids[k].add(int(people.id[apart[k].argmin()]))
    assert [len(each) for each in ids] == [1, 1, 1]
