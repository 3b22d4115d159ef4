"""LiDARs and depth cameras against themselves: repeated frames, covered lenses."""

import numpy as np
import pytest

from cohelm.health import HealthParameters
from cohelm.health.clouds import cloud_symptoms, update_clouds
from cohelm.messages import Observation, PointCloud, Reason
from cohelm.simulation import Fault, generator
from cohelm.simulation.faults.injection import FaultMemory, with_faults

MOUNTS = np.array([[0.4, 0.0, 0.8, 0.0, 0.6, 0.0], [0.0, 0.0, 1.4, 0.0, 0.0, 0.0]])


def observed(k, rng):
    """The k-th observation of two sensors with noise."""
    clouds = tuple(
        PointCloud(
            time=0.1 * k,
            mount=mount,
            points=rng.uniform(1.0, 4.0, (60, 3)).astype(np.float32),
            range_max=10.0,
        )
        for mount in MOUNTS
    )
    return Observation(
        time=0.1 * k,
        pose=np.zeros(3),
        pose_time=0.1 * k,
        twist=np.zeros(3),
        twist_time=0.1 * k,
        clouds=clouds,
    )


def symptoms(*faults):
    """Symptoms at each of twenty instants, and the clouds as they were delivered."""
    rng, memory, states, out, clouds = np.random.default_rng(0), FaultMemory(), (), [], []
    for k in range(20):
        seen, memory = with_faults(
            observed(k, rng), faults, memory, lambda i, what: generator(0, f"{i} {what}")
        )
        states = update_clouds(states, seen, HealthParameters())
        out.append(cloud_symptoms(states, seen.time))
        clouds.append(seen.clouds)
    return out, clouds


def fault(kind, magnitude=None):
    return Fault(kind=kind, at=1.0, duration=99.0, magnitude=magnitude)


@pytest.mark.parametrize(
    ("kind", "magnitude", "reason"),
    [
        ("cloud_frozen", None, Reason.SCAN_FROZEN),
        ("cloud_covered", 0.05, Reason.SCAN_BLIND),
        ("cloud_covered", 0.0, Reason.SCAN_PARTLY_BLIND),
    ],
)
def test_a_covered_or_frozen_sensor_is_noticed_at_once(kind, magnitude, reason):
    out, _ = symptoms(fault(kind, magnitude))
    assert out[:10] == [[]] * 10
    # a frozen one repeats the frame before the onset
    assert out[10:] == [[reason, reason]] * 10


def test_sound_sensors_are_not_doubted_and_silent_ones_are_left_to_the_gate():
    out, _ = symptoms()
    assert out == [[]] * 20
    states = update_clouds((), observed(0, np.random.default_rng(0)), HealthParameters())
    assert cloud_symptoms([s._replace(symptom=Reason.SCAN_BLIND) for s in states], 1.0) == []


def test_a_tilted_sensor_turns_what_it_sees_about_the_robots_y_axis():
    _, sound = symptoms()
    _, tilted = symptoms(fault("cloud_tilted", 8.0))
    # down: level floor ahead of the sensor on level mount seems higher
    before, after = sound[15][1].points, tilted[15][1].points
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), np.linalg.norm(before, axis=1), 1e-5)
    np.testing.assert_allclose(after[:, 1], before[:, 1], 1e-5)
    turned = np.arctan2(after[:, 2], after[:, 0]) - np.arctan2(before[:, 2], before[:, 0])
    np.testing.assert_allclose(turned, np.radians(8.0), rtol=1e-3)


def test_a_sensor_that_is_mounted_higher_than_stated():
    _, raised = symptoms(fault("cloud_raised", 0.02))
    assert [cloud.mount[2] for cloud in raised[15]] == pytest.approx(MOUNTS[:, 2] - 0.02)
