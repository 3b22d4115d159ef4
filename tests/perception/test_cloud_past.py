import dataclasses
import math

import numpy as np
import pytest

from cohelm.perception import CloudClusters
from cohelm.perception.change_detection.cloud_changes import detect_cloud_changes, remember_cloud
from cohelm.robots import load_robot
from cohelm.simulation.sensors import HumanBodies
from cohelm.testing.scenes import open_floor

from .clouds import HERE, NOBODY, cloud_of, scenery

SOMEBODY = HumanBodies.standing(np.array([[4.0, 0.5]]))


def seen_at(time, bodies):
    cloud = dataclasses.replace(cloud_of(scenery(ceiling=np.inf), bodies), time=time)
    return CloudClusters().detect((cloud,), HERE[None], open_floor())


def camera_at(time, X_MR, bodies):
    mount = load_robot("quantum_q6_edge_lidar").depth_cameras[0]
    cloud = cloud_of(scenery(ceiling=np.inf), bodies, mount, X_MR)
    cloud = dataclasses.replace(cloud, time=time)
    return CloudClusters().detect((cloud,), X_MR[None], open_floor())


def after(bodies):
    """The past after two seconds of looking at ``bodies``."""
    past = ()
    for k in range(20):
        past = remember_cloud(past, seen_at(0.1 * k, bodies))
    return past


@pytest.mark.parametrize(("before", "came"), [(NOBODY, True), (SOMEBODY, False)])
def test_who_stands_where_floor_was_seen_has_come_there(before, came):
    seen = detect_cloud_changes(seen_at(2.0, SOMEBODY), after(before))
    near = np.hypot(*(seen.position - [4.0, 0.5]).T).argmin()
    assert (seen.arrival_log_odds[near] > 0.0) == came
    assert (seen.arrival_log_odds[near] < 0.0) == (not came)


def test_without_a_past_nothing_is_said_to_have_come_and_nobody_is_denied():
    seen = detect_cloud_changes(seen_at(0.0, SOMEBODY), ())
    assert len(seen.arrival_log_odds) == len(seen.position)
    assert ((seen.arrival_log_odds < 0.0) & (seen.arrival_log_odds > -1.0)).all()


def test_what_a_camera_turns_to_was_not_empty_before():
    turned = np.array([0.0, 0.0, math.pi])
    past = ()
    for k in range(20):
        past = remember_cloud(past, camera_at(0.1 * k, turned, SOMEBODY))
    seen = detect_cloud_changes(camera_at(2.0, HERE, SOMEBODY), past)
    assert len(seen.arrival_log_odds)
    assert (seen.arrival_log_odds < 0.0).all()


def test_who_comes_into_a_camera_s_view_has_come():
    past = ()
    for k in range(20):
        past = remember_cloud(past, camera_at(0.1 * k, HERE, NOBODY))
    seen = detect_cloud_changes(camera_at(2.0, HERE, SOMEBODY), past)
    assert (seen.arrival_log_odds > 0.0).any()
