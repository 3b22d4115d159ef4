"""LiDARs and depth cameras against themselves: repeated frames, covered lenses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cohelm.arrays import replace
from cohelm.evaluation import run
from cohelm.health import HealthParameters
from cohelm.health.clouds import cloud_symptoms, update_clouds
from cohelm.messages import Observation, PointCloud, Reason
from cohelm.scenarios import load_scenario
from cohelm.simulation import Fault, generator
from cohelm.simulation.faults.injection import FaultMemory, with_faults

MOUNTS = np.array([[0.4, 0.0, 0.8, 0.1, 0.6, 0.5], [0.0, 0.0, 1.4, 0.0, 0.0, 0.0]])


def observed(k, rng, *, still=False):
    """The k-th observation of two sensors with noise, on a chair that drives."""
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
        pose=np.array([0.0 if still else 0.05 * k, 0.0, 0.0]),
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


def test_equal_frames_at_rest_are_no_fault_and_a_frozen_sensor_stays_one_until_it_changes():
    p, rng = HealthParameters(), np.random.default_rng(0)
    first = observed(0, rng)

    def later(k, x, clouds=first.clouds):
        clouds = tuple(replace(cloud, time=0.1 * k) for cloud in clouds)
        return replace(first, time=0.1 * k, pose=np.array([x, 0.0, 0.0]), clouds=clouds)

    states = update_clouds((), first, p)
    for k in range(1, 5):
        states = update_clouds(states, later(k, 0.0), p)
        assert cloud_symptoms(states, 0.1 * k) == []
    for k, x in ((5, 0.05), (6, 0.05), (7, 0.05)):
        states = update_clouds(states, later(k, x), p)
        assert cloud_symptoms(states, 0.1 * k) == [Reason.SCAN_FROZEN] * 2
    states = update_clouds(states, later(8, 0.05, observed(8, rng).clouds), p)
    assert cloud_symptoms(states, 0.8) == []


def test_rows_without_a_return_are_not_equal_returns():
    p, rng = HealthParameters(), np.random.default_rng(0)
    states = ()
    for k in range(5):
        seen = observed(k, rng)
        rows = np.full((900, 3), np.inf, np.float32)
        clouds = tuple(replace(c, points=np.concatenate([c.points, rows])) for c in seen.clouds)
        states = update_clouds(states, replace(seen, clouds=clouds), p)
        assert cloud_symptoms(states, seen.time) == []


def test_a_frozen_sensor_stops_the_chair():
    settings = "robot=quantum_q6_edge_lidar", "people.count=0", "time_limit=4", "mode=autonomous"
    fault = "faults=[{kind: cloud_frozen, at: 2.5, duration: 99}]"
    ticks = []
    run(load_scenario("empty", [*settings, fault]), 0, lambda tick, truth: ticks.append(tick))
    stops = [t for t in ticks if t.health.stop is Reason.SCAN_FROZEN]
    assert 2.5 <= stops[0].observation.time <= 3.1
    assert not any(t.health.findings for t in ticks if t.observation.time < 2.5)


def test_a_tilted_sensor_turns_what_it_sees_about_the_robots_y_axis():
    _, sound = symptoms()
    _, tilted = symptoms(fault("cloud_tilted", 8.0))
    for before, after in zip(sound[15], tilted[15], strict=True):
        R_RS = Rotation.from_euler("xyz", before.mount[3:])
        down = Rotation.from_euler("y", 8.0, degrees=True)
        np.testing.assert_allclose(
            down.apply(R_RS.apply(after.points)), R_RS.apply(before.points), atol=1e-5
        )


def test_a_sensor_that_is_mounted_higher_than_stated():
    _, raised = symptoms(fault("cloud_raised", 0.02))
    assert [cloud.mount[2] for cloud in raised[15]] == pytest.approx(MOUNTS[:, 2] - 0.02)
