"""The twin's drive: its low-speed limit is the planar one, and its mechanics obey statics."""

import math

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision
from cohelm.simulation.drivetrain import at_rest, drive_command, step_drivetrain

OPEN = OccupancyGrid(data=np.zeros((10, 10), np.int8), resolution=0.05, X_MG=np.zeros(3))
GRAVITY = 9.81


def gentle(robot):
    """Half the accelerations, and casters without friction."""

    def free(casters):
        zero = dict.fromkeys(
            ("swivel_friction", "swivel_damping", "friction", "rolling_resistance"), 0.0
        )
        return casters.model_copy(update=zero)

    chassis = robot.chassis
    halved = ("max_acceleration", "max_deceleration", "max_turn_acceleration")
    return robot.model_copy(
        update={
            **{name: getattr(robot, name) / 2.0 for name in halved},
            "chassis": chassis.model_copy(
                update={"front": free(chassis.front), "rear": free(chassis.rear)}
            ),
        }
    )


def on_open_floor(bench, robot):
    return bench(robot=robot, grid=OPEN, heights=None, start=np.zeros(3))


def deviation(bench, robot, rng, low=0.5):
    """Greatest distance between both chairs after each of five commands, as share of the way."""
    twin, planar, way, worst = on_open_floor(bench, robot), at_rest(robot, np.zeros(3)), 0.0, 0.0
    for _ in range(5):
        twist = np.array([rng.uniform(-0.3, 1.2 * low), 0.0, rng.uniform(-1.2, 1.2) * low])
        twin.drive(twist, 2.0)
        command = drive_command(robot, Decision(twist=twist))
        for _ in range(200):
            before = planar.pose
            planar = step_drivetrain(robot, planar, command, 0.01)
            way += math.hypot(*(planar.pose - before)[:2])
        worst = max(worst, math.hypot(*(planar.pose - twin.chair.pose)[:2]))
    return worst / way


@pytest.mark.parametrize("sequences", [3, pytest.param(20, marks=pytest.mark.slow)])
def test_the_low_speed_limit_is_the_planar_drive(bench, chair, sequences):
    rng = np.random.default_rng(1)
    found = [deviation(bench, gentle(chair), rng) for _ in range(sequences)]
    assert max(found) <= 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("prepare", "low", "limit"), [(lambda r: r, 0.5, 0.01), (gentle, 1.0, 0.03)]
)
def test_the_chair_as_it_is_and_at_full_speed_deviates_little(bench, chair, prepare, low, limit):
    """Side forces and turning on the same tyre make it slip: more than 1 % at full speed."""
    rng = np.random.default_rng(1)
    found = [deviation(bench, prepare(chair), rng, low) for _ in range(20)]
    assert max(found) <= limit


def test_the_wheels_carry_the_weight(bench, chair):
    """Statics: the loads of the chassis, and their sum is the weight."""
    resting = on_open_floor(bench, chair)
    resting.drive((0.0, 0.0, 0.0), 1.0)
    twin, loads = resting.chair.twin, {}
    force = np.zeros(6)
    for i in range(twin.data.ncon):
        resting.chair._mujoco.mj_contactForce(twin.model, twin.data, i, force)
        names = [twin.model.geom(g).name for g in twin.data.contact[i].geom]
        wheel = next(name for name in names if not name.startswith("floor"))
        loads[wheel.rsplit("_", 1)[0]] = loads.get(wheel.rsplit("_", 1)[0], 0.0) + force[0]
    weight = float(twin.model.body_subtreemass[twin.model.body("chair").id]) * GRAVITY
    assert sum(loads.values()) == pytest.approx(weight, rel=0.005)
    front, rear = chair.chassis.caster_loads
    assert loads["caster_front"] / weight == pytest.approx(front, abs=0.01)
    assert loads["caster_rear"] / weight == pytest.approx(rear, abs=0.01)
    assert loads["drive"] / weight == pytest.approx(chair.chassis.drive.load, abs=0.01)


def test_an_emergency_stop_brakes_as_configured(bench, chair):
    """v²/2a, and v times the lag before the brakes grip."""
    running = on_open_floor(bench, chair)
    running.drive((1.0, 0.0, 0.0), 4.0)
    start, speed = running.chair.pose, running.chair.twist[0]
    running.drive((0.0, 0.0, 0.0), 2.0, emergency=True)
    way = math.hypot(*(running.chair.pose - start)[:2])
    expected = speed**2 / (2.0 * chair.emergency_deceleration) + speed * chair.actuation_lag
    assert way == pytest.approx(expected, rel=0.15)


def test_casters_flip_after_reversing_and_push_the_chair_aside(bench, chair):
    """Forwards the trail points back; straight after reversing the wheels swing by half a turn."""
    turning = on_open_floor(bench, chair)
    turning.drive((-0.3, 0.0, 0.05), 5.0)
    twin = turning.chair.twin
    angle = [float(twin.data.joint(f"swivel_front_{side}").qpos[0]) for side in ("left", "right")]
    assert min(abs(np.cos(a) + 1.0) for a in angle) < 0.2  # reversed: cos of half a turn is -1
    turning.drive((0.5, 0.0, 0.0), 5.0)
    after = [float(twin.data.joint(f"swivel_front_{side}").qpos[0]) for side in ("left", "right")]
    assert min(np.cos(a) for a in after) > 0.9


def test_equal_commands_give_equal_rides(bench):
    runs = []
    for _ in range(2):
        twin = bench()
        twin.drive((0.6, 0.0, 0.4), 1.0)
        runs.append(np.array(twin.poses))
    assert np.array_equal(*runs)
