"""Speed of the simulated 3-D sensors among people on a hospital floor.

Thread CPU time on one core; numba compiles before the clock starts.

Run: ``python benchmarks/lidar.py``
"""

from __future__ import annotations

import sys
import time
from importlib.metadata import version

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.scenario import floor_file
from cohelm.maps import OccupancyGrid, read_floor_plan
from cohelm.robots import CloudMount, DepthCameraMount, LidarMount
from cohelm.simulation.sensors import Bodies, Scenery, sweep_cloud

PEOPLE = 20
WITHIN = 10.0
"""Of the chair, m."""
MOUNTS = {
    "LiDAR, 16 x 360": LidarMount(rings=16, azimuths=360),
    "LiDAR, 32 x 1024": LidarMount(),
    "LiDAR, 32 x 1024, tilted": LidarMount(pose=(0.0, 0.0, 1.3, 0.05, 0.1, 0.0)),
    "depth camera, 106 x 60": DepthCameraMount(),
}


def main() -> int:
    """Print all figures."""
    print(f"numpy {np.__version__}, numba {version('numba')}; {PEOPLE} people within {WITHIN:g} m")
    grid, _ = read_floor_plan(floor_file("hospital")).draw()
    for name, mount in MOUNTS.items():
        spent = 1e3 * sweep_times(mount, grid)
        print(
            f"{name}: {len(spent)} sweeps, median {np.median(spent):.2f} ms, "
            f"p99 {np.percentile(spent, 99):.2f} ms, worst {spent.max():.2f} ms"
        )
    return 0


def sweep_times(
    mount: CloudMount, grid: OccupancyGrid, *, places: int = 50, times: int = 6, seed: int = 0
) -> Floats:
    """Thread CPU time of sweeps at random free places among people, (places · times,) s."""
    rng = np.random.default_rng(seed)
    free = grid.centres(np.argwhere(grid.data == 0))
    scenery = Scenery(grid=grid)
    out = []
    for _ in range(places):
        here = free[rng.integers(len(free))]
        away = np.hypot(*(free - here).T)
        about = free[(away > 0.8) & (away < WITHIN)]
        bodies = walking(about[rng.integers(len(about), size=PEOPLE)], rng)
        X_MR = np.array([*here, rng.uniform(-np.pi, np.pi)])
        sweep_cloud(mount, scenery, bodies, X_MR, time=0.0, rng=rng)
        for _ in range(times):
            begun = time.thread_time()
            sweep_cloud(mount, scenery, bodies, X_MR, time=0.0, rng=rng)
            out.append(time.thread_time() - begun)
    return np.array(out)


def walking(position: Floats, rng: np.random.Generator) -> Bodies:
    """People at positions (n, 2), m, of all heights and somewhere in their stride."""
    n = len(position)
    return Bodies(
        position=position,
        heading=rng.uniform(-np.pi, np.pi, n),
        walked=rng.uniform(0.0, 10.0, n),
        speed=np.full(n, 1.2),
        height=rng.uniform(1.55, 1.9, n),
        radius=np.full(n, 0.25),
    )


if __name__ == "__main__":
    sys.exit(main())
