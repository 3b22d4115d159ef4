"""The twin's sensors see the floor that the planar ray caster sees, and what only a body sees."""

import dataclasses
import math

import numpy as np
import pytest

from cohelm.maps import distance_field
from cohelm.platforms.twin import TwinChair
from cohelm.robots import LaserMount
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.static_scene import StaticScene

EXACT = LaserMount(noise=0.0, dropout=0.0)


def scan_of(chair, visible=None, mount=EXACT):
    people = chair.twin.people
    visible = np.ones(people, dtype=bool) if visible is None else visible
    casting = chair.casting(None, None, visible)
    return casting.scan(mount, time=0.0, rng=np.random.default_rng(0)).ranges


@pytest.mark.parametrize("name", ["hospital", "corridor-2", "office-3"])
def test_ranges_are_those_of_the_planar_ray_caster(mujoco, name):
    world = build_scenario(load_scenario(name, ["people.count=0"]), 0).world
    world = dataclasses.replace(world, heights=None)  # a planar scanner sees all heights
    chair = TwinChair(mujoco, world)
    rng = np.random.default_rng(3)
    free = np.argwhere(distance_field(world.grid).distance > 0.5)
    for cell in rng.choice(free, 20):
        pose = np.array([*world.grid.centres(cell), rng.uniform(-math.pi, math.pi)])
        chair._place(pose)
        seen = scan_of(chair)
        planar = sweep(
            EXACT, world.grid, np.empty((0, 3)), pose, time=0.0, rng=np.random.default_rng(0)
        ).ranges
        # A ray may pass a corner on either side by rounding; nothing else may differ.
        off = ~(np.isclose(seen, planar, atol=1e-3) | (np.isinf(seen) & np.isinf(planar)))
        assert off.sum() <= 1


def test_a_pitched_scanner_sees_the_floor(mujoco, empty):
    """Height over the sine of the pitch: straight ahead, and nothing behind before the wall."""
    chair = TwinChair(mujoco, empty.world)
    chair._place(np.array([7.0, 7.0, 0.0]))
    pitch = math.radians(5.0)
    chair.twin.data.qpos[3:7] = (math.cos(pitch / 2.0), 0.0, math.sin(pitch / 2.0), 0.0)
    ranges = scan_of(chair)
    height = empty.robot.chassis.laser_height * math.cos(pitch)
    assert ranges[180] == pytest.approx(height / math.sin(pitch), abs=1e-6)
    assert ranges[0] > ranges[180]


def test_low_furniture_is_under_the_scanner(mujoco):
    low = ["obstacles=[{at: [4.0, 7.0], size: [0.4, 0.4], height: 0.2}]", "start=[2, 7, 0]"]
    high = [low[0].replace("0.2}", "0.6}"), low[1]]
    ranges = [
        scan_of(TwinChair(mujoco, build_scenario(load_scenario("empty", each), 0).world))[180]
        for each in (low, high)
    ]
    assert ranges[0] > 3.0
    assert ranges[1] == pytest.approx(1.8, abs=0.03)


def test_glass_is_solid_and_unseen(mujoco):
    pane = ["obstacles=[{at: [4.0, 7.0], size: [0.1, 2.0], sensed: false}]", "start=[2, 7, 0]"]
    world = build_scenario(load_scenario("empty", pane), 0).world
    chair = TwinChair(mujoco, world)
    assert scan_of(chair)[180] > 3.0
    walls = chair.twin.contacts.other == -1
    assert (chair.twin.model.geom_group[walls] == 4).any()


def test_people_are_two_legs_to_a_low_scanner_and_may_be_hidden(mujoco):
    person = ["people.pedestrians=[{points: [[4.0, 7.0]]}]", "start=[2, 7, 0]"]
    world = build_scenario(load_scenario("empty", person), 0).world
    chair = TwinChair(mujoco, world)
    seen, hidden = scan_of(chair), scan_of(chair, np.zeros(1, dtype=bool))
    near = 150 + np.flatnonzero(seen[150:210] < 2.3)
    assert len(near) >= 4
    assert (hidden[near] > 2.3).all()


def test_a_cloud_is_cast_from_the_same_body(mujoco):
    """The depth camera's lowest ray meets the level floor at height over the sine of its angle."""
    world = build_scenario(load_scenario("lidar"), 0).world
    chair = TwinChair(mujoco, world)
    mount = world.robot.depth_cameras[0].model_copy(update={"noise": 0.0, "dropout": 0.0})
    casting = chair.casting(StaticScene(grid=world.grid), None, np.ones(chair.twin.people, bool))
    points = casting.cloud(mount, time=0.0, rng=np.random.default_rng(0)).points
    _, _, z, _, pitch, _ = mount.pose
    c, s = math.cos(pitch), math.sin(pitch)
    heights = z - s * points[:, 0] + c * points[:, 2]
    floor = np.isfinite(heights) & (heights < 0.05)
    assert floor.sum() > 100
    assert np.median(np.abs(heights[floor])) < 0.003


def test_the_inertial_unit_feels_gravity_and_turns(bench):
    twin = bench()
    twin.drive((0.0, 0.0, 0.0), 0.5)
    assert twin.chair.inertial.acceleration == pytest.approx([0.0, 0.0, 9.81], abs=0.05)
    twin.drive((0.0, 0.0, 0.5), 2.0)
    assert twin.chair.inertial.turn_rate[2] == pytest.approx(0.5, abs=0.02)
