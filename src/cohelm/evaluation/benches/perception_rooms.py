"""What perception makes of rooms in which nobody is, seen from a chair that drives through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cohelm.evaluation.benches.perception_rows import Row, row
from cohelm.evaluation.perceived import ChairLine, drive_line
from cohelm.evaluation.scenario import floor_file
from cohelm.evaluation.watching import NO_MAP, Seen, perception_of, watch
from cohelm.maps import OccupancyGrid, distance_field, read_floor_plan
from cohelm.messages import PointCloud, Scan
from cohelm.recordings import Frame
from cohelm.robots import Robot, load_robot
from cohelm.simulation import generator
from cohelm.simulation.sensors import Bodies, Scenery, scan_cloud, sweep

LINES = {
    "hall": ChairLine(centre=np.array([7.0, 7.0]), axis=0.4, ends=(-5.0, 5.0)),
    "corridors": ChairLine(centre=np.array([13.0, 3.3]), axis=0.0, ends=(-8.0, 8.0)),
    "hospital": ChairLine(centre=np.array([14.0, 12.0]), axis=0.0, ends=(-8.0, 8.0)),
}
"""Floor → where the chair drives to and fro."""
ROBOTS = {"laser": "quantum_q6_edge", "LiDAR": "quantum_q6_edge_lidar"}
"""Sensor → the chair that has it."""
DRIVES = tuple((floor, sensor) for floor in ("hall", "corridors") for sensor in ROBOTS)
SECONDS = 40.0


def empty(floor: str, sensor: str, settings: Sequence[str] = ()) -> Iterator[Row]:
    """A drive through a floor where nobody is, with its map and without."""
    grid = read_floor_plan(floor_file(floor)).draw()[0]
    frames = list(drive(grid, load_robot(ROBOTS[sensor]), LINES[floor]))
    for walls, said in ((NO_MAP, "no map"), (distance_field(grid), "its map")):
        seen = list(watch(frames, perception_of(settings), walls))
        ids = {int(who) for each in seen for who in each.perceived.people.id}
        where = f"the floor '{floor}', {SECONDS:.0f} s, {_sensing(seen)}"
        yield row(
            "nobody there", f"{floor}, {sensor}, {said}", len(ids), unit="told", most=0,
            remark=where,
        )  # fmt: skip


def drive(
    grid: OccupancyGrid,
    robot: Robot,
    line: ChairLine,
    *,
    bodies: Bodies | None = None,
    seconds: float = SECONDS,
) -> Iterator[Frame]:
    """What the robot's sensors, all at once, see of a floor on the way along a line.

    Args:
        grid: the floor; what stands on it is as high as walls.
        robot: that carries the sensors.
        line: on which it drives.
        bodies: who stands there; None: nobody.
        seconds: how long.
    """
    bodies = Bodies.standing(np.empty((0, 2))) if bodies is None else bodies
    scenery = Scenery(grid=grid)
    discs = np.column_stack([bodies.position, bodies.radius])
    rng = generator(0, "drive")
    for pose, observation in drive_line(line, seed=0, seconds=seconds):
        time = observation.time
        scans: list[Scan] = [
            sweep(mount, grid, discs, pose, time=time, rng=rng) for mount in robot.lasers
        ]
        clouds: list[PointCloud] = [
            scan_cloud(mount, scenery, bodies, pose, time=time, rng=rng)
            for mount in robot.cloud_mounts
        ]
        yield Frame(observation=replace(observation, scans=tuple(scans), clouds=tuple(clouds)))


def _sensing(seen: list[Seen]) -> str:
    said = dict.fromkeys(each.perceived.sensing.value for each in seen)
    return f"{len(seen)} frames, sensing {', '.join(said)}"
