"""Poses registered with the map: sweeps in a room of 8 × 6 m from poses reported wrong."""

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.geometry import compose, wrap_angle
from cohelm.health import HealthParameters, HealthState, beam_map, registered
from cohelm.health.map_fit import BeamTable, fit_map
from cohelm.health.sweeps import ScannerState
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid, distance_field
from cohelm.messages import Observation
from cohelm.robots import load_robot

RESOLUTION = 0.05
ANGLES = np.arange(120) * 2.0 * np.pi / 120
TRUE = np.array([3.0, 2.0, 0.4])
MOUNT = (0.5, 0.1, 0.3)
CHAIR = load_robot("quantum_q6_edge")
ROBOT = CHAIR.model_copy(update={"lasers": (CHAIR.lasers[0].model_copy(update={"pose": MOUNT}),)})


def room():
    data = np.full((140, 180), OCCUPIED, dtype=np.int8)
    data[10:130, 10:170] = FREE
    grid = OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.array([-0.5, -0.5, 0.0]))
    return beam_map(grid, distance_field(grid))


KNOWN = room()


def ranges_at(sensor):
    """Exact ranges (n,) to the walls of the room, which spans 0…8 and 0…6 m."""
    a = sensor[2] + ANGLES
    with np.errstate(divide="ignore"):
        x = np.where(np.cos(a) > 0, 8.0 - sensor[0], -sensor[0]) / np.cos(a)
        y = np.where(np.sin(a) > 0, 6.0 - sensor[1], -sensor[1]) / np.sin(a)
    return np.minimum(np.abs(x), np.abs(y))


def corrected(error, *, change=lambda ranges: ranges, **parameters):
    """Error (3,) that is left of an error (3,) of the reported pose."""
    reported = TRUE + error
    beams = BeamTable(ANGLES, change(ranges_at(compose(TRUE, MOUNT))), np.ones(120, dtype=bool))
    fit = fit_map(KNOWN, beams, compose(reported, MOUNT), 10.0, 0.15)
    state = ScannerState(0.0, beams.range, None, fit, beams, None, None)
    observation = Observation(
        time=0.0, pose=reported, pose_time=0.0, twist=np.zeros(3), twist_time=0.0
    )
    p = HealthParameters(**parameters)
    left = registered(observation, HealthState(scanners=(state,)), ROBOT, p).pose - TRUE
    return np.array([left[0], left[1], wrap_angle(left[2])])


ERRORS = np.array([[0.03, 0.0, 0.0], [0.0, -0.03, 0.0], [0.0, 0.0, 0.017], [0.02, -0.02, -0.01]])


@pytest.mark.parametrize("error", ERRORS)
def test_a_pose_that_is_wrong_by_centimetres_is_put_right(error):
    left = corrected(error)
    assert np.hypot(*left[:2]) < 0.1 * RESOLUTION
    assert abs(left[2]) < 0.002


def test_people_and_things_before_the_walls_change_little():
    hidden = np.arange(120) % 3 == 0
    left = corrected(ERRORS[3], change=lambda r: np.where(hidden, 0.6 * r, r))
    assert np.hypot(*left[:2]) < 0.1 * RESOLUTION


def test_a_correction_is_no_larger_than_a_localiser_is_wrong():
    error = np.array([0.2, 0.0, 0.0])
    sensor_moves = np.hypot(*(corrected(error) - error)[:2])
    lever = np.hypot(*MOUNT[:2]) * HealthParameters().registration_turn
    assert 0.05 < sensor_moves <= HealthParameters().registration_shift + lever


def test_few_beams_on_walls_or_no_bounds_leave_the_pose_as_reported():
    few = corrected(ERRORS[0], change=lambda r: np.where(np.arange(120) % 5 > 0, 0.5 * r, r))
    np.testing.assert_allclose(few, ERRORS[0], atol=1e-12)
    off = corrected(ERRORS[0], registration_shift=0.0, registration_turn=0.0)
    np.testing.assert_allclose(off, ERRORS[0], atol=1e-12)


def test_a_chair_without_a_sweep_keeps_its_pose():
    observation = Observation(time=0.0, pose=TRUE, pose_time=0.0, twist=np.zeros(3), twist_time=0.0)
    for state in (HealthState(), HealthState(scanners=(None,))):
        assert identical(registered(observation, state, ROBOT, HealthParameters()), observation)
