"""Mechanics of the twin's chair, measured by manoeuvres in MuJoCo, for the table of docs/twin.md.

    python benchmarks/twin_mechanics.py [ROBOT]          # about a minute

Loads on the wheels, tip angles, stopping distances, turning on the spot, casters that flip after
reversing, distance from a planner's trajectory, and the highest threshold and the steepest ramp
that the chair takes.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.trajectories import limited_trajectory
from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision
from cohelm.platforms.twin import TwinChair, load_mujoco
from cohelm.robots import Robot, load_robot
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import CrowdStep, FloorPiece, FloorRelief, WorldSetup
from cohelm.simulation.drivetrain import drive_command
from cohelm.simulation.sensors.floor_relief import FloorSurface
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.testing.scenes import local_problem

STEP, DT = 0.05, 0.01
OPEN = OccupancyGrid(data=np.zeros((10, 10), np.int8), resolution=0.05, X_MG=np.zeros(3))
NOBODY = HumanBodies.standing(np.empty((0, 2)))
mujoco = load_mujoco()


class Manoeuvre:
    """The chair alone on an open floor."""

    def __init__(self, robot: Robot, relief: FloorRelief | None = None) -> None:
        base = build_scenario(load_scenario("empty", ["people.count=0"]), 0).world
        self.world: WorldSetup = replace(
            base,
            robot=robot,
            grid=OPEN,
            heights=None,
            start=np.zeros(3),
            relief=relief or FloorRelief(),
        )
        self.chair = TwinChair(mujoco, self.world)
        self.model, self.data = self.chair.twin.model, self.chair.twin.data

    def drive(self, twist: tuple[float, float], seconds: float, *, emergency: bool = False) -> None:
        """Follow (v, ω) for a time."""
        decision = Decision(twist=np.array([twist[0], 0.0, twist[1]]), emergency=emergency)
        command, crowd = drive_command(self.world.robot, decision), self.world.crowd
        for _ in range(round(seconds / STEP)):
            step = CrowdStep(
                before=crowd,
                after=crowd,
                people=lambda _: NOBODY,
                grid=OPEN,
                gap_people=np.empty(0),
                gap_wall=np.inf,
            )
            self.chair.begin(step)
            for k in range(round(STEP / DT)):
                self.chair.move(command, DT, (k + 1) * DT / STEP, lambda given: given)
            self.chair.end()

    def loads(self) -> dict[str, float]:
        """Force on the floor by wheel, N."""
        out: dict[str, float] = {}
        force = np.zeros(6)
        for i in range(self.data.ncon):
            mujoco.mj_contactForce(self.model, self.data, i, force)
            names = [self.model.geom(g).name for g in self.data.contact[i].geom]
            wheel = next(name for name in names if not name.startswith("floor"))
            out[wheel] = out.get(wheel, 0.0) + force[0]
        return out


def tip_angle(robot: Robot, direction: float) -> float:
    """Slope, degrees, at which the braked chair has lost a side's last wheel and tips.

    Gravity turns towards a direction of the chair's frame at 2°/s.
    """
    tipping = Manoeuvre(robot)
    tipping.drive((0.0, 0.0), 0.5)
    for angle in np.arange(0.0, 50.0, 0.1):
        g, a = 9.81, math.radians(angle)
        down = g * math.sin(a)
        tipping.model.opt.gravity[:] = (
            down * math.cos(direction),
            down * math.sin(direction),
            -g * math.cos(a),
        )
        tipping.drive((0.0, 0.0), 0.05)
        _, x, y, _ = tipping.data.qpos[3:7]
        if 2.0 * math.hypot(x, y) > math.radians(12.0):
            return float(angle)
        if math.hypot(*tipping.chair.pose[:2]) > 0.5:
            return -float(angle)  # slid away first
    return 50.0


def stopping(robot: Robot, *, emergency: bool) -> float:
    """Stopping distance from full speed, m."""
    running = Manoeuvre(robot)
    running.drive((robot.max_speed, 0.0), 4.0)
    start = running.chair.pose
    running.drive((0.0, 0.0), 3.0, emergency=emergency)
    return float(np.hypot(*(running.chair.pose - start)[:2]))


def turning_radius(robot: Robot) -> tuple[float, float]:
    """Radius about the first centre that a turn on the spot sweeps, and the centre's drift, m."""
    turning = Manoeuvre(robot)
    reach, drift = 0.0, 0.0
    for _ in range(160):
        turning.drive((0.0, 0.8), 0.05)
        x, y, yaw = turning.chair.pose
        c, s = math.cos(yaw), math.sin(yaw)
        corners = robot.outline @ np.array([[c, s], [-s, c]]) + [x, y]
        reach = max(reach, float(np.hypot(*corners.T).max()))
        drift = max(drift, math.hypot(x, y))
    return reach, drift


def caster_kick(robot: Robot) -> tuple[float, float]:
    """Offset aside, m, and heading, degrees, 1.5 m ahead after reversing in a bend, straight on."""
    kicked = Manoeuvre(robot)
    kicked.drive((-0.3, 0.3), 4.0)
    kicked.drive((0.0, 0.0), 1.0)
    x, y, yaw = kicked.chair.pose
    while True:
        kicked.drive((0.5, 0.0), 0.05)
        dx, dy = kicked.chair.pose[0] - x, kicked.chair.pose[1] - y
        ahead = math.cos(yaw) * dx + math.sin(yaw) * dy
        if ahead > 1.5:
            turned = math.remainder(kicked.chair.pose[2] - yaw, 2.0 * math.pi)
            return math.cos(yaw) * dy - math.sin(yaw) * dx, math.degrees(turned)


def climbs(robot: Robot, height: float, speed: float) -> bool:
    """Check that the chair gets over a bar of 5 cm depth, head on."""
    return passes(robot, (1.5, 0.05), height, speed)


def mounts(robot: Robot, height: float, speed: float) -> bool:
    """Check that the chair gets onto a step."""
    return passes(robot, (3.5, 4.0), height, speed)


def passes(robot: Robot, run: tuple[float, float], height: float, speed: float) -> bool:
    """Check that the chair gets past 2.3 m, with an edge whose middle and depth are ``run``."""
    middle, depth = run
    edge = FloorPiece(
        at=np.array([middle, 0.0]), size=np.array([depth, 3.0]), angle=0.0, height=height
    )
    ride = Manoeuvre(robot, FloorRelief(pieces=(edge,)))
    ride.drive((speed, 0.0), 3.5 / speed + 3.0)
    return bool(ride.chair.pose[0] > 2.3)


def takes_ramp(robot: Robot, degrees: float) -> bool:
    """Check that the chair drives up a ramp of 3 m, and stands on it."""
    ramp = FloorSurface(
        at=np.array([1.2, 0.0]), direction=0.0, gradient=math.tan(math.radians(degrees)), length=6.0
    )
    up = Manoeuvre(robot, FloorRelief(floor=ramp))
    up.drive((0.5, 0.0), 7.0)
    at = up.chair.pose[0]
    up.drive((0.0, 0.0), 4.0)
    return bool(at > 2.6 and abs(up.chair.pose[0] - at) < 0.4)


def greatest(values: Iterator[float] | list[float], holds: Callable[[float], bool]) -> float:
    """Return the last of rising values before the first that does not hold."""
    best = 0.0
    for value in values:
        if not holds(value):
            return best
        best = value
    return best


def foretold(robot: Robot, sequences: int = 12) -> Floats:
    """Mean distance (3,) of the chair from a planner's trajectory after 0.6, 1.05 and 2.1 s, m.

    The inputs change every 0.75 s at random.
    """
    rng, out = np.random.default_rng(0), []
    problem = replace(local_problem(steps=14, step=0.15, speed=0.0), robot=robot)
    for _ in range(sequences):
        targets = np.column_stack([rng.uniform(0.0, 1.0, 3), rng.uniform(-0.6, 0.6, 3)])
        plan = limited_trajectory(problem, np.repeat(targets, 5, axis=0)[:14], np.zeros(2))
        chair = Manoeuvre(robot)
        driven = [chair.chair.pose]
        for v, turn in plan.inputs:
            chair.drive((v, turn), 0.15)
            driven.append(chair.chair.pose)
        off = plan.poses - (np.array(driven) - driven[0])
        out.append(np.hypot(off[[4, 7, 14], 0], off[[4, 7, 14], 1]))
    return np.mean(out, axis=0)


def main() -> None:
    """Print the table."""
    robot = load_robot(sys.argv[1] if len(sys.argv) > 1 else "quantum_q6_edge")
    resting = Manoeuvre(robot)
    resting.drive((0.0, 0.0), 1.0)
    weight = sum(resting.loads().values())
    print(f"mass {weight / 9.81:.0f} kg, centre {robot.chassis.centre}")
    for name, load in sorted(resting.loads().items()):
        print(f"load {name}: {load:.0f} N, {load / weight:.1%}")
    for name, direction in (("forward", 0.0), ("backward", math.pi), ("sideways", math.pi / 2.0)):
        print(f"tip angle {name}: {tip_angle(robot, direction):.1f} deg (negative: slid first)")
    print(
        f"stopping from {robot.max_speed} m/s: {stopping(robot, emergency=False):.2f} m,", end=" "
    )
    print(f"emergency {stopping(robot, emergency=True):.2f} m")
    print(
        "turn on the spot, swept radius and drift: {:.3f} m, {:.3f} m".format(
            *turning_radius(robot)
        )
    )
    print("1.5 m after reversing: {:.3f} m aside, {:.1f} deg".format(*caster_kick(robot)))
    print(f"off a planner's trajectory: {np.round(100.0 * foretold(robot), 1)} cm")
    heights = [0.01 * k for k in range(1, 13)]
    for speed in (0.3, 0.6, 1.0):
        bar = greatest(heights, lambda h, v=speed: climbs(robot, h, v))
        step = greatest(heights, lambda h, v=speed: mounts(robot, h, v))
        print(f"highest bar and step at {speed} m/s: {100 * bar:.0f} cm, {100 * step:.0f} cm")
    slopes = [float(k) for k in range(3, 25)]
    print(f"steepest ramp: {greatest(slopes, lambda a: takes_ramp(robot, a)):.0f} deg")


if __name__ == "__main__":
    main()
