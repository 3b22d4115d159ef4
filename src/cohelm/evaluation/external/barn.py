"""Two-dimensional port of the BARN worlds (Perille et al. 2020): data, rides and score.

A Jackal drives from (−2.25, 3) to within 1 m of (−2.25, 13) through fields of cylinders that only
its planar scanner detects. The original runs in Gazebo with full robot dynamics. Here worlds,
start, goal, limits and score are the same, but the robot is planar: results of the two must not be
compared.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.errors import ConfigError
from cohelm.geometry import distance_to_polygon, transform
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid, write_map
from cohelm.navigation import Navigator, Tick
from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.scenario import Scenario, load_scenario
from cohelm.simulation import World

ROBOT = "jackal"
FILE = "barn/barn_worlds.json"
"""File in the folder of the outside data."""
FASTEST = 2.0
"""Speed of the optimal time, m/s."""

_RESOLUTION, _FINE = 0.05, 0.0125
"""Resolution of the navigator's grid and of the true one, m."""
_BOUNDS = (-6.5, -1.0, 2.0, 15.0)
"""Bounds of the grids: all worlds with a margin of 2 m, m."""

SETTINGS: Mapping[str, Any] = {
    "mode": "autonomous",
    "robot": ROBOT,
    "people": {"count": 0},
    "tracker": "given",
    "group_detector": "no_groups",
    # the score rewards a mean of up to 1 m/s
    "profile": {"preferred_speed": 1.5, "clearance": 0.0},
    # no localiser: odometry drifts slowly instead of jittering (assumed)
    "localisation": {
        "position_bound": 0.02,
        "heading_bound_deg": 0.3,
        "correlation_time": 20.0,
    },
    "obstacle_layer": {"side": 12.0},
    "replanning": {
        "blocked_time": 0.05,
        "lookahead": 8.0,
        "max_deviation": 0.4,
        "min_interval": 0.2,
    },
    "comfort": {"lateral_acceleration": 1.5, "deceleration": 1.5, "approach": 0.5},
    "progress": {"time_allowance": 2.0},
}
"""Changed parameters of the navigator. The tracker is given that there are no people, because a
cylinder looks like a leg."""


class BarnOutcome(StrEnum):
    """End of a ride through a world."""

    SUCCESS = "success"
    """Arrival within the goal's tolerance in time without a contact."""
    COLLISION = "collision"
    """The footprint touched a cylinder."""
    TIMEOUT = "timeout"


@value
class BarnWorlds:
    """Common data of all worlds, and the n worlds."""

    source: str
    radius: float
    """Radius of each cylinder, m."""
    start: Annotated[Floats, Shape("3")]
    """X_MR."""
    goal: Annotated[Floats, Shape("2")]
    goal_tolerance: float
    """m."""
    time_limit: float
    """s."""
    cylinders: tuple[Floats, ...]
    """Centres (c, 2) in each world, m."""
    length: Annotated[Floats, Shape("n")]
    """Length of the reference path, m."""

    def optimal_time(self, world: int) -> float:
        """Optimal time OT: the reference path at 2 m/s, s."""
        return float(self.length[world]) / FASTEST


@value
class BarnRide:
    """One ride; k control ticks, true states."""

    world: int
    outcome: BarnOutcome
    time: Annotated[Floats, Shape("k")]
    pose: Annotated[Floats, Shape("k 3")]
    speed: Annotated[Floats, Shape("k")]
    """m/s."""
    least_gap: float
    """Smallest gap between footprint and cylinders, m."""
    replans: int
    held_time: float
    """Time in which gate or planner limited the command with a reason, s."""
    tick_time: Annotated[Floats, Shape("k")]
    """Thread CPU time of each tick, s."""
    control_time: Annotated[Floats, Shape("k")]
    """Thread CPU time of the local planner, s."""
    seen: Annotated[Floats, Shape("m 2")]
    """Centres of the occupied cells of the obstacle layer at the end, m."""


def read_barn(data: Path | None) -> BarnWorlds:
    """Read the worlds from the folder of the outside data.

    Args:
        data: that folder; None: not configured.

    Raises:
        ConfigError: if they do not exist, with the remedy.
    """
    if data is None:
        raise ConfigError(
            "the BARN worlds are outside data: set COHELM_DATA to the folder that holds "
            f"{FILE} (cohelm data)"
        )
    file = data / FILE
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except OSError as cause:
        raise ConfigError(f"{FILE} is not in COHELM_DATA ({cause.strerror})") from None
    except ValueError:
        raise ConfigError("is not JSON", file=file) from None
    names = sorted(found["worlds"], key=int)
    return BarnWorlds(
        source=found["source"],
        radius=float(found["radius"]),
        start=np.array(found["start"], dtype=float),
        goal=np.array(found["goal"], dtype=float),
        goal_tolerance=float(found["goal_tolerance"]),
        time_limit=float(found["time_limit"]),
        cylinders=tuple(np.array(found["worlds"][name], dtype=float) for name in names),
        length=np.array(found["reference_path_length"], dtype=float),
    )


def score(time: float, optimal: float, *, least: float = 2.0) -> float:
    """Score of a success, OT / clip(AT, least·OT, 8·OT); ``least`` was 4 until March 2026."""
    return optimal / min(max(time, least * optimal), 8.0 * optimal)


def barn_setup(
    worlds: BarnWorlds,
    world: int,
    planner: str,
    folder: Path,
    settings: Sequence[str] = (),
    *,
    seed: int = 0,
) -> RideSetup:
    """Set up a ride through one world.

    The navigator's map is an empty floor: all that was not observed is free.

    Args:
        worlds: the data.
        world: index of the world.
        planner: name of a local planner.
        folder: folder for the empty map and the scenario.
        settings: ``dotted.key=value`` of the scenario, applied last.
        seed: seed of the sensor noise.
    """
    write_map(_empty(_RESOLUTION), folder / "empty.yaml")
    file = folder / "barn.yaml"
    x, y, heading = worlds.start
    base = {
        **SETTINGS,
        "map": "empty.yaml",
        "start": [float(x), float(y), math.degrees(heading)],
        "goal": [float(g) for g in worlds.goal],
        "local_planner": {"use": planner},
        "time_limit": worlds.time_limit,
    }
    file.write_text(json.dumps(base), encoding="utf-8")  # JSON is YAML
    scenario: Scenario = load_scenario(file, settings)
    setup = build_scenario(scenario, seed)
    truth = _with_cylinders(_empty(_FINE), worlds.cylinders[world], worlds.radius)
    return dataclasses.replace(setup, world=dataclasses.replace(setup.world, grid=truth))


def ride_barn(worlds: BarnWorlds, world: int, setup: RideSetup) -> BarnRide:
    """Run a ride through one world until the goal, a contact or the time limit."""
    true = World(setup.world, setup.seed)
    navigator = Navigator(setup.navigator)
    outline, cylinders = setup.robot.outline, worlds.cylinders[world]
    rows: list[tuple[float, ...]] = []
    tick: Tick | None = None
    least, held, paths = np.inf, 0.0, 0
    while True:
        truth = true.truth
        least = min(least, _gap(transform(truth.pose, outline), cylinders, worlds.radius))
        before = tick
        tick = navigator.step(true.observe(), setup.request, tick)
        spent = sum(tick.durations.values())
        speed = float(np.hypot(*truth.twist[:2]))
        rows.append((truth.time, *truth.pose, speed, spent, tick.durations.get("control", 0.0)))
        held += setup.world.control_step * (tick.decision.reason is not None)
        paths += before is None or tick.path is not before.path
        outcome = _outcome(worlds, truth.time, truth.pose, hit=truth.hit_wall or least <= 0.0)
        if outcome is not None:
            break
        true.advance(tick.decision)
    log = np.array(rows)
    return BarnRide(
        world=world,
        outcome=outcome,
        time=log[:, 0],
        pose=log[:, 1:4],
        speed=log[:, 4],
        least_gap=least,
        replans=paths - 1,
        held_time=held,
        tick_time=log[:, 5],
        control_time=log[:, 6],
        seen=_occupied_cells(tick, setup.grid),
    )


def _outcome(worlds: BarnWorlds, time: float, pose: Floats, *, hit: bool) -> BarnOutcome | None:
    if hit:
        return BarnOutcome.COLLISION
    if float(np.hypot(*(pose[:2] - worlds.goal))) <= worlds.goal_tolerance:
        return BarnOutcome.SUCCESS
    return BarnOutcome.TIMEOUT if time >= worlds.time_limit - 1e-9 else None


def _gap(polygon: Floats, cylinders: Floats, radius: float) -> float:
    near = cylinders[np.abs(cylinders - polygon.mean(axis=0)).max(axis=1) < 1.5]
    gaps = [float(distance_to_polygon(polygon, x, y)) for x, y in near]
    return min(gaps, default=np.inf) - radius


def _occupied_cells(tick: Tick, grid: OccupancyGrid) -> Floats:
    layer = tick.memory.obstacles
    if layer is None:
        return np.empty((0, 2))
    cells = np.argwhere(layer.obstacles.occupied > 0) + layer.obstacles.corner
    return grid.centres(cells)


def _empty(resolution: float) -> OccupancyGrid:
    x0, y0, x1, y1 = _BOUNDS
    shape = round((y1 - y0) / resolution), round((x1 - x0) / resolution)
    return OccupancyGrid(
        data=np.full(shape, FREE, dtype=np.int8),
        resolution=resolution,
        X_MG=np.array([x0, y0, 0.0]),
    )


def _with_cylinders(grid: OccupancyGrid, centres: Floats, radius: float) -> OccupancyGrid:
    """Grid with every cell occupied whose centre a cylinder covers."""
    data = grid.data.copy()
    reach = math.ceil(radius / grid.resolution) + 1
    near = np.arange(-reach, reach + 1)
    window = np.stack(np.meshgrid(near, near), axis=-1).reshape(-1, 2)
    cells = (grid.cells(centres)[:, None] + window).reshape(-1, 2)
    away = grid.centres(cells).reshape(len(centres), -1, 2) - centres[:, None]
    covered = cells[(np.hypot(away[..., 0], away[..., 1]) <= radius).ravel()]
    data[covered[:, 0], covered[:, 1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)
