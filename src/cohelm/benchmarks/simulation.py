"""Simulator compared with references: ORCA with recorded RVO2, people near a cart; times.

The recordings are the people of CrowdNav's 500 circle-crossing cases, who never see the robot. Row
t holds the position of each person after t steps of 0.25 s, and the velocity that led there. All
times are thread CPU times on one core, without compilation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Task, missing_data
from cohelm.benchmarks.cart_encounters import cart_encounters
from cohelm.benchmarks.claims import (
    measured,
    measured_notes,
    measured_sheets,
    skipped,
)
from cohelm.evaluation.external.crowdnav import DT, RADIUS, REPLAY, SPEED
from cohelm.maps import OccupancyGrid, read_floor_plan
from cohelm.recordings.outside_data import outside_file
from cohelm.robots import CloudMount, DepthCameraMount, LidarMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import Crowd, CrowdScene, Orca
from cohelm.simulation.sensors import HumanBodies, StaticScene, sweep_cloud
from cohelm.stopwatch import Stopwatch, Timing

TITLE = "Simulator: ORCA against RVO2, people near a cart, computing time of crowds and sensors"
EXACT = 1e-3
"""Largest difference of equal velocities, m/s."""
FREE_STEPS = 40
"""Steps of a free run from the first recorded state."""
CROWDS = (12, 50, 200)
PEOPLE, WITHIN = 20, 10.0
"""People around a sensor, and their largest distance, m."""
MOUNTS: Mapping[str, CloudMount] = {
    "LiDAR, 16 × 360": LidarMount(rings=16, azimuths=360),
    "LiDAR, 32 × 1024": LidarMount(),
    "LiDAR, 32 × 1024, tilted": LidarMount(pose=(0.0, 0.0, 1.3, 0.05, 0.1, 0.0)),
    "depth camera, 106 × 60": DepthCameraMount(),
}
CROWDNAV = Orca.Parameters(
    time_horizon=5.0,
    max_neighbors=10,
    neighbor_dist=10.0,
    extra_radius=0.01,
    max_speed_factor=1.0,
    walls=False,
    perturbation=0.0,
)
"""Parameters of the recorded people."""

_WARM_UP = 5


@dataclass(frozen=True)
class SimulationBench:
    """The benchmark; its rows do not depend on the seeds."""

    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """Agreement, people near a cart, crowds, sensors."""
        return [
            ("rvo2",),
            ("cart",),
            *(("crowd", n) for n in CROWDS),
            *(("sensor", name) for name in MOUNTS),
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Rows of one part."""
        kind, *given = task
        parts: Mapping[str, Callable[..., Iterator[dict[str, Any]]]]
        parts = {
            "rvo2": agreement,
            "cart": cart_encounters,
            "crowd": crowd_cost,
            "sensor": sensor_cost,
        }
        return [Result(row) for row in parts[kind](*given)]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per part."""
        rows = [result.row for result in results]
        return BenchReport(measured_sheets(rows), measured_notes(rows), {})


def create() -> SimulationBench:
    """Create the benchmark."""
    return SimulationBench()


def agreement() -> Iterator[dict[str, Any]]:
    """Difference from RVO2: one step from every recorded state, and a free run from the first."""
    part, file = "ORCA against recorded RVO2", outside_file(*REPLAY.parts)
    if file is None:
        yield skipped(part, "velocities", missing_data(*REPLAY.parts))
        return
    with np.load(file) as recorded:
        states, goals = recorded["pos_vel"], recorded["goals"]
    error = np.array([_step_errors(case, goal) for case, goal in zip(states, goals, strict=True)])
    walking = np.hypot(states[:, 1:, :, 2], states[:, 1:, :, 3]) > EXACT
    for name, values in (("all", error), ("walking", error[walking])):
        p999 = np.percentile(values, 99.9)
        yield measured(
            part,
            f"velocities within {EXACT:g} m/s, {name}",
            100.0 * float(np.mean(values < EXACT)),
            unit="%",
            remark=f"{values.size} velocities; median {np.median(values):.1e}, p99.9 {p999:.1e}, "
            f"maximum {values.max():.1e} m/s",
        )
    drift = np.array([_drift(case, goal) for case, goal in zip(states, goals, strict=True)])
    yield measured(
        part,
        f"drift after {FREE_STEPS} steps, median",
        float(np.median(drift)),
        unit="m",
        remark=f"p99 {np.percentile(drift, 99):.1e}, maximum {drift.max():.1e} m",
    )


def _step_errors(states: Floats, goal: Floats) -> Floats:
    """Differences (t − 1, n) of velocities after one step from each of states (t, n, 4), m/s."""
    chosen = np.array([one_step(state, goal)[:, 2:] for state in states[:-1]])
    errors: Floats = np.hypot(*np.moveaxis(chosen - states[1:, :, 2:], -1, 0))
    return errors


def _drift(states: Floats, goal: Floats) -> Floats:
    """Distances (n,) of a free run from the recorded positions, m."""
    state = states[0]
    for _ in range(FREE_STEPS):
        state = one_step(state, goal)
    drift: Floats = np.hypot(*(state[:, :2] - states[FREE_STEPS, :, :2]).T)
    return drift


def one_step(state: Floats, goal: Floats) -> Floats:
    """State (n, 4) of people one recorded step later, steered to goals (n, 2) as in CrowdNav."""
    n = len(state)
    crowd = Crowd(
        position=state[:, :2],
        velocity=state[:, 2:],
        heading=np.zeros(n),
        radius=np.full(n, RADIUS),
        preferred_speed=np.full(n, SPEED),
        waypoints=goal[:, None, :],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=bool),
        sees_robot=np.zeros(n, dtype=bool),
    )
    wanted = goal - state[:, :2]
    wanted = wanted / np.maximum(np.hypot(wanted[:, 0], wanted[:, 1]), 1.0)[:, None]
    empty = OccupancyGrid(data=np.zeros((1, 1), dtype=np.int8), resolution=1.0, X_MG=np.zeros(3))
    velocity = Orca(CROWDNAV).velocities(crowd, _scene(empty, np.zeros(2)), wanted, np.ones(n), DT)
    return np.hstack([state[:, :2] + DT * velocity, velocity])


def crowd_cost(count: int) -> Iterator[dict[str, Any]]:
    """Cost of one step of ORCA in a hall with walls and pillars."""
    crowd, scene = busy_hall(count)
    model, rng, times = Orca(), np.random.default_rng(0), []
    for _ in range(_WARM_UP + 200):
        watch = Stopwatch()
        crowd = model.step(crowd, scene, 0.05, rng)
        times.append(watch.elapsed())
    yield _timed("a step of ORCA with walls", f"{count} people", times[_WARM_UP:])


def busy_hall(count: int) -> tuple[Crowd, CrowdScene]:
    """People who walk to and fro in a hall with pillars, about 10 m² per person."""
    rng = np.random.default_rng(0)
    side = np.sqrt(10.0 * count)
    cells = int(side / 0.05)
    data = np.zeros((cells, cells), dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = 100
    for r in range(60, cells - 60, 120):
        for c in range(60, cells - 60, 120):
            data[r : r + 10, c : c + 10] = 100
    crowd = Crowd(
        position=rng.uniform(1.0, side - 1.0, (count, 2)),
        velocity=np.zeros((count, 2)),
        heading=np.zeros(count),
        radius=np.full(count, 0.25),
        preferred_speed=rng.uniform(0.8, 1.4, count),
        waypoints=rng.uniform(1.0, side - 1.0, (count, 4, 2)),
        target=np.zeros(count, dtype=np.int64),
        loop=np.ones(count, dtype=bool),
        sees_robot=np.ones(count, dtype=bool),
    )
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    return crowd, _scene(grid, np.full(2, side / 2.0))


def sensor_cost(name: str, places: int = 50, times: int = 6) -> Iterator[dict[str, Any]]:
    """Cost of sweeps at random free places of the hospital among people."""
    mount, rng = MOUNTS[name], np.random.default_rng(0)
    grid, _ = read_floor_plan(floor_file("hospital")).draw()
    free = grid.centres(np.argwhere(grid.data == 0))
    scenery, spent = StaticScene(grid=grid), []
    for _ in range(places):
        here = free[rng.integers(len(free))]
        away = np.hypot(*(free - here).T)
        about = free[(away > 0.8) & (away < WITHIN)]
        bodies = walking(about[rng.integers(len(about), size=PEOPLE)], rng)
        X_MR = np.array([*here, rng.uniform(-np.pi, np.pi)])
        sweep_cloud(mount, scenery, bodies, X_MR, time=0.0, rng=rng)
        for _ in range(times):
            watch = Stopwatch()
            sweep_cloud(mount, scenery, bodies, X_MR, time=0.0, rng=rng)
            spent.append(watch.elapsed())
    part = f"a sweep on the hospital floor, {PEOPLE} people within {WITHIN:g} m"
    yield _timed(part, name, spent)


def walking(position: Floats, rng: np.random.Generator) -> HumanBodies:
    """People at positions (n, 2), m, of all heights and at random moments of their gait."""
    n = len(position)
    return HumanBodies(
        position=position,
        heading=rng.uniform(-np.pi, np.pi, n),
        walked=rng.uniform(0.0, 10.0, n),
        speed=np.full(n, 1.2),
        height=rng.uniform(1.55, 1.9, n),
        radius=np.full(n, 0.25),
    )


def _scene(grid: OccupancyGrid, robot: Floats) -> CrowdScene:
    return CrowdScene(
        grid=grid, robot_position=robot, robot_velocity=np.zeros(2), robot_radius=0.6, time=0.0
    )


def _timed(part: str, name: str, times: Sequence[float]) -> dict[str, Any]:
    timing = Timing.of(times)
    remark = f"{timing.rounds} times; p99 {timing.p99:.3f} ms, maximum {timing.maximum:.3f} ms"
    return measured(part, f"{name}, median", timing.median, unit="ms", remark=remark)
