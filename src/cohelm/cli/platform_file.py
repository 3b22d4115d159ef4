"""File of a real chair: platform, robot, map and limits, for ``cohelm drive --platform FILE``.

    platform: {use: ros2, scans: [/scan]}   or  {use: my_chair:MyChair, port: /dev/ttyACM0}
    robot: my_robot.yaml                    name, or file beside this one
    map: floor.yaml                         Nav2 map; without it the floor is open and unknown
    max_speed: 0.2                          m/s, until the therapist changes it
    stick: {device: /dev/input/js0}         rider's stick at this computer
    scenario: {gate: {scan_limit: 0.25}}    other keys of a scenario

``module:Class`` is looked for beside the file first.
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.cli.requests import DriveRequest
from cohelm.config import Model, load
from cohelm.live.messages import Limits
from cohelm.maps import OccupancyGrid, write_map
from cohelm.plugins import Spec
from cohelm.scenarios import Scenario
from cohelm.scenarios.scenario import PoseOrPlace, robot_of

OPEN_FLOOR = 60.0
"""Side of the floor where there is no map, m; the chair starts in its middle."""
_RESOLUTION = 0.05
"""m."""


class PlatformFile(Model):
    """Content of the file; see the module."""

    name: str = ""
    """Name for the rider; default: the file's."""
    platform: Spec
    """Platform and its parameters."""
    robot: str = "quantum_q6_edge"
    map: str | None = None
    start: PoseOrPlace | None = None
    """Place on the map, for the first plan only; default: its first place or most open point."""
    max_speed: float | None = Field(None, ge=0.1, le=3.0)
    """m/s."""
    stick: dict[str, Any] | None = None
    """Stick at this computer: parameters of ``platforms.WithStick``."""
    scenario: dict[str, Any] = Field(default_factory=dict)
    """Other keys of a scenario: parts, gate, comfort, profile."""


def read(file: Path) -> PlatformFile:
    """Read the file of a chair.

    Raises:
        ConfigError: naming the file and the key.
    """
    given = load(PlatformFile, file)
    sys.path.insert(0, str(file.absolute().parent))  # for module:Class
    return given


def ride_of(
    given: PlatformFile, file: Path, request: DriveRequest, files: contextlib.ExitStack
) -> tuple[Scenario, Limits | None]:
    """Return the ride of a file's content, and its limits.

    Args:
        given: Content of the file.
        file: File of the chair.
        request: Options of the command; they win over the file.
        files: Removes temporary files when the ride is over.

    Raises:
        CohelmError: naming the file and the key.
    """
    from cohelm.cli.drive import scenario_of_drive

    map_, start = request.map or _beside(file, given.map), request.start or _text(given.start)
    if map_ is None:
        map_, start = str(open_floor(Path(files.enter_context(folder())))), "0,0,0"
    settings = tuple(f"{key}={json.dumps(each)}" for key, each in given.scenario.items())
    robot = _beside(file, given.robot)
    robot = robot if robot is not None and Path(robot).is_file() else given.robot
    scenario = scenario_of_drive(
        replace(
            request,
            scenario="empty",
            map=map_,
            start=start,
            people=0,
            robot=request.robot or robot,
            settings=(*settings, *request.settings),
        )
    )
    name, platform = given.name or file.stem, given.platform
    if given.stick is not None:
        platform = {"use": "with_stick", **given.stick, "platform": given.platform}
    scenario = scenario.model_copy(update={"platform": platform, "name": name}).in_file(file)
    return scenario, _limits(given, scenario)


def open_floor(folder: Path) -> Path:
    """Write the map of an open floor about the origin, and return its file."""
    cells = round(OPEN_FLOOR / _RESOLUTION)
    corner = np.array([-OPEN_FLOOR / 2.0, -OPEN_FLOOR / 2.0, 0.0])
    data = np.zeros((cells, cells), dtype=np.int8)
    file = folder / "open-floor.yaml"
    write_map(OccupancyGrid(data=data, resolution=_RESOLUTION, X_MG=corner), file)
    return file


def _limits(given: PlatformFile, scenario: Scenario) -> Limits | None:
    if given.max_speed is None:
        return None
    robot, profile = robot_of(scenario), scenario.profile
    return Limits(
        max_speed=min(given.max_speed, robot.max_speed),
        max_acceleration=robot.max_acceleration,
        min_distance=profile.social_distance,
    )


def folder() -> tempfile.TemporaryDirectory[str]:
    """Return a temporary folder, as a context."""
    return tempfile.TemporaryDirectory(prefix="cohelm-")


def _beside(file: Path, name: str | None) -> str | None:
    return None if name is None else str(file.absolute().parent / name)


def _text(start: PoseOrPlace | None) -> str | None:
    if start is None or isinstance(start, str):
        return start
    return ",".join(f"{each:g}" for each in start)
