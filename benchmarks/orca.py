"""Our ORCA against recorded RVO2 people, and its speed.

The recordings are the people of CrowdNav's 500 circle-crossing test cases, who never see the robot:
``COHELM_DATA/crowdnav/crowdnav_replay_circle_crossing_5.npz`` (default ``../shared/data``). Row t
holds where each person is after t steps of 0.25 s, and the velocity that led there.

Run: ``python benchmarks/orca.py``
"""

from __future__ import annotations

import os
import sys
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid
from cohelm.simulation import Crowd, Orca, Scene

STEP = 0.25
EXACT = 1e-3
FREE_RUN = 40
CROWDNAV = Orca.Parameters(
    time_horizon=5.0,
    max_neighbors=10,
    neighbor_dist=10.0,
    extra_radius=0.01,
    max_speed_factor=1.0,
    walls=False,
    perturbation=0.0,
)


def main() -> int:
    """Print all figures."""
    print(f"numpy {np.__version__}, numba {version('numba')}")
    file = Path(os.environ.get("COHELM_DATA") or "../shared/data")
    file = file / "crowdnav" / "crowdnav_replay_circle_crossing_5.npz"
    if file.exists():
        with np.load(file) as recorded:
            report_agreement(recorded["pos_vel"], recorded["goals"])
    else:
        print(f"no recordings: {file} does not exist (set COHELM_DATA)", file=sys.stderr)
    report_speed()
    return 0


def report_agreement(states: Floats, goals: Floats) -> None:
    """One step from every recorded state, then free-running from the first.

    Args:
        states: (cases, t, people, 4) recorded.
        goals: (cases, people, 2).
    """
    cases, times, people, _ = states.shape
    error = np.empty((cases, times - 1, people))
    for case in range(cases):
        for t in range(times - 1):
            chosen = one_step(states[case, t], goals[case])[:, 2:]
            error[case, t] = np.hypot(*(chosen - states[case, t + 1, :, 2:]).T)
    walking = np.hypot(states[:, 1:, :, 2], states[:, 1:, :, 3]) > EXACT
    for name, part in (("all", error), ("while walking", error[walking])):
        print(
            f"one step, {name}: {part.size} velocities, {100 * np.mean(part < EXACT):.4f} % within "
            f"{EXACT} m/s, median {np.median(part):.1e}, p99.9 {np.percentile(part, 99.9):.1e}, "
            f"worst {part.max():.1e} m/s"
        )
    drift = np.empty((cases, people))
    for case in range(cases):
        state = states[case, 0]
        for _ in range(FREE_RUN):
            state = one_step(state, goals[case])
        drift[case] = np.hypot(*(state[:, :2] - states[case, FREE_RUN, :, :2]).T)
    print(
        f"{FREE_RUN} steps free-running: median {np.median(drift):.1e}, "
        f"p99 {np.percentile(drift, 99):.1e}, worst {drift.max():.1e} m"
    )


def one_step(state: Floats, goal: Floats) -> Floats:
    """The state (n, 4) of people one recorded step later, as CrowdNav steers them to ``goal``."""
    n = len(state)
    crowd = Crowd(
        position=state[:, :2],
        velocity=state[:, 2:],
        heading=np.zeros(n),
        radius=np.full(n, 0.3),
        preferred_speed=np.ones(n),
        waypoints=goal[:, None, :],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=bool),
        sees_robot=np.zeros(n, dtype=bool),
    )
    wanted = goal - state[:, :2]
    wanted = wanted / np.maximum(np.hypot(wanted[:, 0], wanted[:, 1]), 1.0)[:, None]
    velocity = Orca(CROWDNAV).velocities(crowd, NOWHERE, wanted, np.ones(n), STEP)
    return np.hstack([state[:, :2] + STEP * velocity, velocity])


def report_speed() -> None:
    """Thread CPU time of one step in a building: density as in the hospital, walls included."""
    for n in (12, 50, 200):
        crowd, scene = busy_hall(n)
        model, rng = Orca(), np.random.default_rng(0)
        took = []
        for _ in range(205):
            begin = time.thread_time()
            crowd = model.step(crowd, scene, 0.05, rng)
            took.append(1e3 * (time.thread_time() - begin))
        median, worst = np.median(took[5:]), np.max(took[5:])
        print(f"{n} people with walls: median {median:.3f}, worst {worst:.3f} ms a step")


def busy_hall(n: int) -> tuple[Crowd, Scene]:
    """``n`` people walking to and fro in a hall with pillars, about 10 m² for each."""
    rng = np.random.default_rng(0)
    side = np.sqrt(10.0 * n)
    cells = int(side / 0.05)
    data = np.zeros((cells, cells), dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = 100
    for r in range(60, cells - 60, 120):
        for c in range(60, cells - 60, 120):
            data[r : r + 10, c : c + 10] = 100
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    crowd = Crowd(
        position=rng.uniform(1.0, side - 1.0, (n, 2)),
        velocity=np.zeros((n, 2)),
        heading=np.zeros(n),
        radius=np.full(n, 0.25),
        preferred_speed=rng.uniform(0.8, 1.4, n),
        waypoints=rng.uniform(1.0, side - 1.0, (n, 4, 2)),
        target=np.zeros(n, dtype=np.int64),
        loop=np.ones(n, dtype=bool),
        sees_robot=np.ones(n, dtype=bool),
    )
    scene = Scene(
        grid=grid,
        robot_position=np.full(2, side / 2.0),
        robot_velocity=np.zeros(2),
        robot_radius=0.6,
        time=0.0,
    )
    return crowd, scene


NOWHERE = Scene(
    grid=OccupancyGrid(data=np.zeros((1, 1), dtype=np.int8), resolution=1.0, X_MG=np.zeros(3)),
    robot_position=np.zeros(2),
    robot_velocity=np.zeros(2),
    robot_radius=0.3,
    time=0.0,
)

if __name__ == "__main__":
    sys.exit(main())
