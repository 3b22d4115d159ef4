"""Check of a robot before anything moves: watch its topics, compare scans with the map."""

from __future__ import annotations

import queue
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from cohelm.arrays import Floats
from cohelm.geometry import compose, transform
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.messages import Decision, Observation, Scan
from cohelm.robots import Robot
from cohelm.ros2.conversions import grid_of
from cohelm.ros2.findings import (
    CheckFinding,
    check_base,
    check_inputs,
    check_map,
    check_motion,
    check_sensors,
    missing_map,
)
from cohelm.ros2.parameters import Ros2Parameters
from cohelm.ros2.platform import RobotNode, Ros2Platform
from cohelm.ros2.transport import LATCHED, make_node
from cohelm.scenarios import Scenario
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.scenario import robot_of

MAP = "nav_msgs/msg/OccupancyGrid"
_TEST_SPEED, _TEST_TIME = 0.1, 2.0
"""Test drive: m/s and s."""
_SIDE = 900
"""Maximum side of the picture, pixels."""
_MARGIN = 6.0
"""Distance from the chair to the edges of the picture, m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Result of a check."""

    findings: tuple[CheckFinding, ...]
    grid: OccupancyGrid
    robot: Robot
    observation: Observation
    scans: tuple[Scan, ...]
    """Newest scan of each scanner."""


def check(
    parameters: Ros2Parameters, scenario: Scenario, *, watch: float, has_map: bool = True
) -> Report:
    """Watch the topics of a robot and compare them with map and robot.

    Args:
        parameters: Topics and frames.
        scenario: Map and robot.
        watch: Time to watch, s.
        has_map: False if the map of the topic did not come.

    Raises:
        PlatformError: There is no network.
        CohelmError: Map or robot cannot be read.
    """
    grid, robot = floor_of(scenario).grid, robot_of(scenario)
    node = RobotNode(parameters)
    try:
        time.sleep(watch)
        offered = node.dds.published()
        inputs = node.inputs
        observation = inputs.observation()
        findings = check_inputs(parameters, inputs, offered)
        findings.append(check_base(parameters, node.dds.subscribers(parameters.command)))
        if parameters.map is not None and not has_map:
            findings.append(missing_map(parameters.map, offered))
        scans = tuple(inputs.last_scan.values())
        findings += check_sensors(parameters, robot, scans)
        localised = parameters.frames.map is not None and observation.pose_time > 0.0
        if localised and has_map:
            walls = distance_field(grid)
            findings += check_map(grid, walls, observation.pose, scans)
    finally:
        node.close()
    return Report(
        findings=tuple(findings), grid=grid, robot=robot, observation=observation, scans=scans
    )


def move(parameters: Ros2Parameters) -> CheckFinding:
    """Drive 0.2 m forward at 0.1 m/s, and compare with the odometry."""
    node = RobotNode(parameters)
    try:
        node.wait()
        platform = Ros2Platform(node)
    except BaseException:
        node.close()
        raise
    try:
        before = platform.observe().pose
        end = time.monotonic() + _TEST_TIME
        while time.monotonic() < end:
            platform.apply(Decision(twist=np.array([_TEST_SPEED, 0.0, 0.0])))
            time.sleep(0.05)
        platform.apply(Decision(twist=np.zeros(3), emergency=True))
        time.sleep(0.5)
        after = platform.observe().pose
    finally:
        platform.close()
    return check_motion(_TEST_SPEED * _TEST_TIME, before, after)


def take_map(parameters: Ros2Parameters) -> OccupancyGrid | None:
    """Return the map of the robot's topic; None: it does not come in time."""
    maps: queue.SimpleQueue[OccupancyGrid] = queue.SimpleQueue()
    node = make_node(parameters, f"{parameters.name}_map")
    node.subscribe(parameters.map or "/map", MAP, LATCHED, lambda m: maps.put(grid_of(m)))
    node.start()
    try:
        return maps.get(timeout=parameters.wait)
    except queue.Empty:
        return None
    finally:
        node.close()


def draw(report: Report, file: Path) -> None:
    """Draw map, chair and scans about the chair as a PNG, x to the right.

    Raises:
        OSError: The file cannot be written.
    """
    pose, side = report.observation.pose, 2.0 * _MARGIN
    scale = _SIDE / side
    corner = pose[:2] - _MARGIN
    pixels = np.arange(_SIDE) / scale
    points = corner + np.stack(np.meshgrid(pixels, pixels[::-1]), axis=-1)
    cells, inside = report.grid.cells(points), report.grid.contains(points)
    shades = np.full((_SIDE, _SIDE), 205, dtype=np.uint8)
    data = report.grid.data[cells[inside][:, 0], cells[inside][:, 1]]
    shades[inside] = np.where(data < 0, 205, np.where(data > 50, 40, 255)).astype(np.uint8)
    image = Image.fromarray(shades).convert("RGB")
    sheet = ImageDraw.Draw(image)

    def pixel(at: Floats) -> list[tuple[float, float]]:
        away = (at - corner) * scale
        return [(float(x), _SIDE - float(y)) for x, y in away]

    for scan in report.scans:
        for x, y in pixel(_ends(scan, pose)):
            sheet.ellipse((x - 2.0, y - 2.0, x + 2.0, y + 2.0), fill=(200, 40, 30))
    outline = transform(pose, report.robot.outline)
    sheet.polygon(pixel(outline), outline=(36, 84, 160), width=3)
    ahead = transform(pose, np.array([[0.0, 0.0], [0.8, 0.0]]))
    sheet.line(pixel(ahead), fill=(36, 84, 160), width=3)
    image.save(file)


def _ends(scan: Scan, pose: Floats) -> Floats:
    """End points (k, 2) of the beams with a return, in the map frame, m."""
    kept = np.isfinite(scan.ranges)
    angle = (scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges)))[kept]
    r = scan.ranges[kept]
    return transform(
        compose(pose, scan.mount), np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    )
