import numpy as np
import pytest

from cohelm.messages import People
from cohelm.perception import (
    GivenPeople,
    KalmanTracker,
    PerceptionParts,
    ScanClusters,
    perceive,
)
from cohelm.perception.cloud_detection.cloud_clusters import CloudClusters
from cohelm.perception.groups.affinity import NoGroups
from cohelm.testing import check_tracker

from .rays import Laser, observation


def given(time, mean, ids, heading=np.nan):
    n = len(ids)
    return People(
        time=time,
        id=np.array(ids, dtype=np.int64),
        mean=np.reshape(np.array(mean, dtype=float), (n, 4)),
        covariance=np.tile(0.01 * np.eye(4), (n, 1, 1)),
        heading=np.full(n, heading),
        radius=np.full(n, 0.3),
        confidence=np.full(n, 0.7),
        source="ceiling camera",
    )


def test_fulfils_the_contract():
    check_tracker(GivenPeople())


def test_people_are_brought_to_now_and_stay_themselves():
    people, _ = GivenPeople().track(
        observation(2.2, people=given(2.0, [[1.0, 2.0, 0.5, -1.0]], [17])), (), None
    )
    assert people.mean[0] == pytest.approx([1.1, 1.8, 0.5, -1.0])
    assert people.covariance[0, 0, 0] > 0.01
    assert (people.id.tolist(), people.source, people.time) == ([17], "ceiling camera", 2.2)
    assert (people.radius[0], people.confidence[0]) == (0.3, 0.7)


def test_old_people_are_not_brought_forward_for_ever_nor_back():
    tracker = GivenPeople()
    old, _ = tracker.track(observation(9.0, people=given(0.0, [[0, 0, 1, 0]], [1])), (), None)
    assert old.mean[0, 0] == pytest.approx(1.0)
    early, _ = tracker.track(observation(0.0, people=given(9.0, [[0, 0, 1, 0]], [1])), (), None)
    assert early.mean[0, 0] == 0.0


def test_headings_are_remembered_by_id():
    tracker = GivenPeople()
    walk = given(0.0, [[0, 0, 0, 1], [3, 0, -1, 0], [5, 5, 0, 0]], [5, 2, 9])
    people, memory = tracker.track(observation(0.0, people=walk), (), None)
    assert people.heading[:2] == pytest.approx([np.pi / 2, np.pi])
    assert np.isnan(people.heading[2])
    rest = given(0.1, [[3, 0, 0, 0], [0, 0, 0, 0], [7, 7, 0, 0]], [2, 5, 1])
    people, memory = tracker.track(observation(0.1, people=rest), (), memory)
    assert people.heading[:2] == pytest.approx([np.pi, np.pi / 2])
    assert np.isnan(people.heading[2])
    told = given(0.2, [[3, 0, 0, 0]], [2], heading=0.3)
    people, _ = tracker.track(observation(0.2, people=told), (), memory)
    assert people.heading[0] == 0.3


def test_none_given_is_nobody():
    people, memory = GivenPeople().track(observation(1.0), (), None)
    assert len(people) == 0
    people, _ = GivenPeople().track(observation(1.1), (), memory)
    assert len(people) == 0


@pytest.mark.parametrize(("tracker", "asks"), [(GivenPeople(), False), (KalmanTracker(), True)])
def test_only_who_asks_is_told_who_has_moved(tracker, asks):
    laser, memory = Laser(), None
    parts = PerceptionParts(
        detector=ScanClusters(),
        cloud_detector=CloudClusters(),
        tracker=tracker,
        group_detector=NoGroups(),
    )
    for time in (0.0, 0.1, 0.2):
        scan, pose = laser.scan(time, (0.0, 0.0, 0.0), [[2.0, 0.5, 0.25]])
        now = observation(time, pose, scans=(scan,))
        seen, memory = perceive(parts, now, laser.walls, memory)
    assert len(seen.detections[0].position) > 0
    assert (seen.detections[0].arrival_log_odds is not None) is asks
    assert bool(memory.past_scans) is asks
