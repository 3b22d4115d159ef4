"""Confidence of the chair: usable beams, covered directions, beams through mapped walls."""

import math

import numpy as np
import pytest

from cohelm.maps import distance_field
from cohelm.messages import ChairConfidence, Observation, Scan
from cohelm.navigation.chair_confidence import update_confidence
from cohelm.testing.scenes import room

POSE = np.array([4.0, 4.0, 0.3])
BEAMS = 360


@pytest.fixture(scope="module")
def walls():
    return distance_field(room(boxes=()))


def observed(ranges, field=2.0 * math.pi):
    step = field / len(ranges)
    scan = Scan(
        time=0.0,
        mount=np.zeros(3),
        angle_min=-field / 2.0,
        angle_increment=step,
        range_max=10.0,
        ranges=np.asarray(ranges, dtype=float),
    )
    return Observation.at_rest(0.0, pose=POSE, scans=(scan,))


def test_short_readings_all_round_contradict_nothing(walls):
    found = update_confidence(observed(np.full(BEAMS, 1.0)), walls, None)
    assert (found.beams, found.coverage, found.map_agreement) == (1.0, 1.0, 1.0)


def test_dropouts_are_no_usable_beams(walls):
    ranges = np.full(BEAMS, 1.0)
    ranges[::4] = np.nan
    assert update_confidence(observed(ranges), walls, None).beams == 0.75


def test_a_scanner_ahead_covers_its_field(walls):
    # 110° of the 220° ahead and beside; a border sector may count or not
    found = update_confidence(observed(np.full(BEAMS, 1.0), math.radians(110.0)), walls, None)
    assert found.coverage == pytest.approx(0.5, abs=1.0 / 44 + 1e-9)


def test_beams_that_end_far_behind_the_walls_contradict_the_map(walls):
    # the room's walls are nearer than 12 m in every direction
    found = update_confidence(observed(np.full(BEAMS, 12.0)), walls, None)
    assert found.map_agreement < 0.2
    assert found.total == pytest.approx(found.beams * found.coverage * found.map_agreement)


def test_without_a_scan_the_last_confidence_stays(walls):
    last = ChairConfidence(beams=0.4, localisation=0.7)
    silent = Observation.at_rest(0.0, pose=POSE)
    assert update_confidence(silent, walls, last) is last
    # a new scan keeps what another stage filled in
    assert update_confidence(observed(np.full(BEAMS, 1.0)), walls, last).localisation == 0.7
