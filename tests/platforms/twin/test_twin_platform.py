"""The twin as a platform: the contract, rides, doors, newcomers, and errors in one line."""

import builtins

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cohelm.arrays import identical
from cohelm.config import validate
from cohelm.errors import PlatformError
from cohelm.evaluation.episode.recorded import run_recorded
from cohelm.messages import Decision
from cohelm.platforms import open_simulation
from cohelm.platforms.twin import Twin
from cohelm.recordings import RecordedRide
from cohelm.robots import load_robot
from cohelm.robots.chassis import Chassis
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import NewPedestrian
from cohelm.testing import check_platform

AHEAD = Decision(twist=np.array([0.5, 0.0, 0.0]))


def opened(scenario, settings=(), seed=0):
    setup = build_scenario(load_scenario(scenario, [*settings, "platform.use=twin"]), seed)
    return open_simulation(setup)


def test_the_twin_is_a_platform():
    check_platform(Twin(Twin.Parameters()))


def test_the_inertial_unit_is_observed_recorded_and_replayed(tmp_path):
    scenario = load_scenario("crossing", ["platform.use=twin", "time_limit=0.5"])
    seen = []
    file = tmp_path / "ride.mcap"
    run_recorded(scenario, 0, file, lambda tick, _: seen.append(tick.observation))
    again = [tick.observation for tick in RecordedRide(file)]
    assert len(again) == len(seen) == 11  # from 0 to 0.5 s
    assert all(identical(*pair) for pair in zip(again, seen, strict=True))
    assert all(each.inertial.acceleration[2] > 8.0 for each in again)
    with AnyReader([file]) as reader:
        [topic] = [each for each in reader.connections if each.topic == "/imu"]
        read = [
            reader.deserialize(data, topic.msgtype).linear_acceleration.z
            for _, _, data in reader.messages([topic])
        ]
    assert read == [each.inertial.acceleration[2] for each in seen]


def test_people_walk_as_in_the_planar_world_while_nothing_touches_them():
    crowds = []
    for platform in ("planar", "twin"):
        scenario = load_scenario("crossing", [f"platform.use={platform}", "people.see_robot=false"])
        there, world = open_simulation(build_scenario(scenario, 0))
        for _ in range(20):
            there.observe()
            there.apply(Decision(twist=np.zeros(3)))
        crowds.append(world.truth.crowd.position)
    assert np.allclose(*crowds, atol=1e-9)


def test_a_door_that_shuts_is_a_wall_with_the_chair_where_it_was():
    platform, world = opened("doorway-standing", ["people.count=0"])
    for _ in range(10):
        platform.apply(AHEAD)
    before, model = platform.chair.pose, platform.chair.twin.model
    assert world.set_door(0, shut=True)
    platform.apply(AHEAD)
    assert platform.chair.twin.model is not model
    assert platform.chair.pose[0] - before[0] == pytest.approx(0.5 * 0.05, abs=0.01)
    assert platform.chair.twist[0] == pytest.approx(0.4, abs=0.15)


def test_a_newcomer_is_a_body():
    platform, world = opened("empty")
    index = world.spawn(NewPedestrian(position=np.array([4.0, 7.0]), waypoints=np.empty((0, 2))))
    platform.apply(AHEAD)
    assert platform.chair.twin.people == index + 1
    at = platform.chair.twin.people_state()[0][index, :2]
    assert at == pytest.approx([4.0, 7.0], abs=1e-6)


def test_a_ramp_lifts_the_chair_by_its_gradient():
    platform, world = opened("ramp", ["people.count=0"])
    for _ in range(260):
        platform.apply(Decision(twist=np.array([0.8, 0.0, 0.0])))
    x = world.truth.pose[0]
    assert 8.0 < x < 12.0
    rise = 0.0833 * (min(x, 10.0) - 6.0)
    assert platform.chair.twin.data.qpos[2] == pytest.approx(rise, abs=0.02)


@pytest.mark.parametrize("robot", ["rear_drive", "front_drive"])
def test_other_chairs_are_one_file(robot):
    platform, world = opened("empty", [f"robot={robot}"])
    for _ in range(60):
        platform.apply(AHEAD)
    assert world.truth.twist[0] == pytest.approx(0.5, abs=0.02)
    assert abs(world.truth.twist[2]) < 0.02
    assert not world.truth.hit_wall


def test_a_robot_without_a_chassis_is_refused():
    with pytest.raises(PlatformError, match="has no chassis"):
        opened("empty", ["robot=jackal"])


def test_a_chassis_that_would_tip_is_refused():
    heavy = {"masses": {"base_centre": [0.6, 0.0, 0.3]}}
    with pytest.raises(Exception, match="carry nothing"):
        validate(Chassis, heavy)


def test_without_mujoco_one_line_says_what_to_install(monkeypatch):
    real = builtins.__import__

    def refuse(name, *args, **kwargs):
        if name == "mujoco":
            raise ModuleNotFoundError("No module named 'mujoco'", name="mujoco")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(PlatformError) as error:
        opened("empty")
    assert str(error.value) == "MuJoCo is not installed: pip install 'cohelm[twin]'"


def test_the_shipped_chair_has_the_mass_of_its_parts():
    chassis = load_robot("quantum_q6_edge").chassis
    assert chassis.total_mass == pytest.approx(118 + 75 + 2 * 9 + 4 * 1.5)
    assert sum(chassis.caster_loads) + chassis.drive.load == pytest.approx(1.0)


@pytest.mark.parametrize("platform", ["planar", "twin"])
def test_a_branch_goes_on_as_its_world_and_neither_changes_the_other(platform):
    setup = build_scenario(load_scenario("crossing", [f"platform.use={platform}"]), 3)
    there, world = open_simulation(setup)
    for _ in range(5):
        there.apply(AHEAD)
    branch = world.branch(())
    for _ in range(10):
        branch.advance(AHEAD)
    assert world.truth.time == pytest.approx(0.25)
    for _ in range(10):
        world.advance(AHEAD)
    np.testing.assert_array_equal(world.truth.pose, branch.truth.pose)
    np.testing.assert_array_equal(world.truth.crowd.position, branch.truth.crowd.position)
