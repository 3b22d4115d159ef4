"""The pipeline as a whole where clocks are out of step: those who are there, and nobody else."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.evaluation.perception.recording_view import NO_MAP, perception_of
from cohelm.messages import Observation
from cohelm.perception import perceive
from cohelm.robots import LidarMount
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud
from cohelm.testing.scenes import room

STEP, FRAMES, TROUBLE = 0.1, 40, 20
HERE = np.array([6.0, 4.0, 0.0])
MOUNT = LidarMount(rings=16, azimuths=512)


@pytest.fixture(scope="module")
def clouds():
    """Two people walk past a chair at rest, at 1.2 m/s."""
    scenery, rng, out = StaticScene(grid=room()), np.random.default_rng(0), []
    for k in range(FRAMES):
        time, way = k * STEP, 1.2 * k * STEP
        bodies = replace(
            HumanBodies.standing(np.array([[3.0 + way, 6.0], [3.5 + way, 2.5]])),
            walked=np.full(2, way),
            speed=np.full(2, 1.2),
        )
        out.append(scan_cloud(MOUNT, scenery, bodies, HERE, time=time, rng=rng))
    return out


def told(clouds, stamps, now):
    """(ids, status) of every frame, the clouds stamped so and seen at these times."""
    memory, out, parts = None, [], perception_of()
    for cloud, stamp, time in zip(clouds, stamps, now, strict=True):
        observation = Observation(
            time=time,
            pose=HERE,
            pose_time=time,
            twist=np.zeros(3),
            twist_time=time,
            clouds=(replace(cloud, time=stamp),),
        )
        perceived, memory = perceive(parts, observation, NO_MAP, memory)
        out.append((perceived.people.id.tolist(), perceived.sensing.value))
    return out


def times():
    return STEP * np.arange(FRAMES)


def test_two_who_walk_by_are_two(clouds):
    got = told(clouds, times(), times())
    assert max(len(ids) for ids, _ in got) == 2
    assert len(got[TROUBLE][0]) == 2
    assert {status for _, status in got} == {"ok"}


@pytest.mark.parametrize("back", [0.3, 0.5, 0.99, 1.5])
def test_a_clock_that_runs_back_makes_nobody(clouds, back):
    stamps = times() - np.where(np.arange(FRAMES) < TROUBLE, 0.0, back)
    got = told(clouds, stamps, stamps)
    assert max(len(ids) for ids, _ in got) == 2
    assert got[TROUBLE][1] == "clock_backwards"
    assert len(got[-1][0]) == 2
    assert not set(got[-1][0]) & set(got[TROUBLE - 1][0])  # ids are never used again


@pytest.mark.parametrize("stamp", [np.nan, np.inf, 3600.0, -3600.0])
def test_one_stamp_that_makes_no_sense_changes_nobody(clouds, stamp):
    stamps = times()
    stamps[TROUBLE] = stamp
    got = told(clouds, stamps, times())
    assert max(len(ids) for ids, _ in got) == 2
    assert got[TROUBLE][1] == "clock_offset"
    assert all(ids == got[TROUBLE - 1][0] for ids, _ in got[TROUBLE:])


def test_a_sensor_of_another_time_is_told(clouds):
    got = told(clouds, times() + 3600.0, times())
    assert {status for _, status in got} == {"clock_offset"}
    assert not any(ids for ids, _ in got)
