"""Perception on floors without people, seen from a chair that drives through."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.benchmarks.claims import NONE, measured
from cohelm.evaluation.perception.filmed_crowd import ChairLine, drive_line
from cohelm.evaluation.perception.recording_view import (
    NO_MAP,
    PerceivedFrame,
    perceive_frames,
    perception_of,
)
from cohelm.maps import OccupancyGrid, distance_field, read_floor_plan
from cohelm.messages import PointCloud, Scan
from cohelm.recordings import Frame
from cohelm.robots import Robot, load_robot
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import generator
from cohelm.simulation.sensors import HumanBodies, StaticScene, scan_cloud, sweep

LINES = {
    "hall": ChairLine(centre=np.array([7.0, 7.0]), axis=0.4, ends=(-5.0, 5.0)),
    "corridors": ChairLine(centre=np.array([13.0, 3.3]), axis=0.0, ends=(-8.0, 8.0)),
    "hospital": ChairLine(centre=np.array([14.0, 12.0]), axis=0.0, ends=(-8.0, 8.0)),
}
"""Floor → line on which the chair drives to and fro."""
ROBOTS = {"laser": "quantum_q6_edge", "LiDAR": "quantum_q6_edge_lidar"}
"""Sensor → chair that has it."""
DRIVES = tuple((floor, sensor) for floor in ("hall", "corridors") for sensor in ROBOTS)
SECONDS = 40.0


def empty(floor: str, sensor: str, settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Drive through an empty floor, with its map and without."""
    grid = read_floor_plan(floor_file(floor)).draw()[0]
    frames = list(drive(grid, load_robot(ROBOTS[sensor]), LINES[floor]))
    for walls, said in ((NO_MAP, "no map"), (distance_field(grid), "its map")):
        seen = list(perceive_frames(frames, perception_of(settings), walls))
        ids = {int(who) for each in seen for who in each.perceived.people.id}
        where = f"the floor '{floor}', {SECONDS:.0f} s, {_sensing(seen)}"
        yield measured(
            "empty floor", f"{floor}, {sensor}, {said}", len(ids), unit="people", bound=NONE,
            remark=where,
        )  # fmt: skip


def drive(
    grid: OccupancyGrid,
    robot: Robot,
    line: ChairLine,
    *,
    bodies: HumanBodies | None = None,
    seconds: float = SECONDS,
) -> Iterator[Frame]:
    """Readings of all the robot's sensors while it drives along a line.

    Args:
        grid: floor; everything on it is as high as walls.
        robot: carries the sensors.
        line: of the drive.
        bodies: standing people; None: no people.
        seconds: duration.
    """
    bodies = HumanBodies.standing(np.empty((0, 2))) if bodies is None else bodies
    scenery = StaticScene(grid=grid)
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


def _sensing(seen: list[PerceivedFrame]) -> str:
    said = dict.fromkeys(each.perceived.sensing.value for each in seen)
    return f"{len(seen)} frames, sensing {', '.join(said)}"
