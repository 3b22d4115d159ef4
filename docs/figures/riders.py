"""Draw the same straight ride with every simulated rider: the picture of docs/riders.md.

    python docs/figures/riders.py

Each rider drives alone in an empty hall; the stick commands the wheels directly.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from cohelm.maps import OccupancyGrid
from cohelm.messages import Decision
from cohelm.plugins import build
from cohelm.robots import load_robot
from cohelm.sharing import stick_twist
from cohelm.simulation import Crowd, Orca, World, WorldSetup

RIDERS = (
    "ideal",
    "laggy",
    "noisy",
    "tremor",
    "delayed",
    "dropout",
    "biased",
    "uncooperative",
    "one_switch",
    "reluctant",
)
ROUTE = np.array([[2.0, 4.0], [12.0, 4.0]])
SPEED = 0.8
LONGEST = 120.0
SILENT = 0.3
"""Time without a heartbeat after which the chair stops, s."""


def main() -> None:
    """Draw the picture."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--plot", type=Path, default=Path("docs/images/riders.png"))
    options.add_argument("--seed", type=int, default=3)
    chosen = options.parse_args()
    figure, axes = plt.subplots(
        len(RIDERS), 2, figsize=(9, 10.5), sharex="col", width_ratios=[3, 2], layout="constrained"
    )
    for name, (track, stick) in zip(RIDERS, axes, strict=True):
        times, poses, deflections = ride(name, chosen.seed)
        track.plot(*ROUTE.T, "--", color="0.6", lw=0.8)
        track.plot(poses[:, 0], poses[:, 1], color="tab:blue", lw=1.4)
        track.set(ylim=(2.7, 5.3), xlim=(1.5, 12.5), yticks=[3, 4, 5])
        track.set_title(f"{name}: {times[-1]:.0f} s", fontsize=9, loc="left", pad=2)
        stick.step(times, deflections[:, 1], color="tab:orange", lw=0.8, where="post")
        stick.set(ylim=(-1.05, 1.05), xlim=(0.0, 15.0), yticks=[-1, 0, 1])
        for each in (track, stick):
            each.tick_params(labelsize=7)
            each.grid(alpha=0.3)
    axes[-1, 0].set_xlabel("x (m); y beside it", fontsize=8)
    axes[-1, 1].set_xlabel("time (s); stick to the left, share of full", fontsize=8)
    figure.savefig(chosen.plot, dpi=80)


def ride(name: str, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (k,), poses (k, 3) and deflections (k, 2) until the chair stands at the goal."""
    robot = load_robot("quantum_q6_edge")
    setup = WorldSetup(
        grid=OccupancyGrid(
            data=np.zeros((160, 280), dtype=np.int8), resolution=0.05, X_MG=np.zeros(3)
        ),
        robot=robot,
        start=np.array([2.0, 4.5, 0.3]),
        crowd=no_people(),
        pedestrian_model=Orca(),
        rider=build("riders", name),
        rider_goal=ROUTE[-1],
        rider_route=ROUTE,
    )
    world, rows = World(setup, seed), []
    while world.truth.time < LONGEST:
        seen, truth = world.observe(), world.truth
        rows.append((truth.time, *truth.pose, *seen.rider.deflection))
        silent = seen.time - seen.rider.heartbeat > SILENT
        deflection = np.zeros(2) if silent else seen.rider.deflection
        world.advance(Decision(twist=stick_twist(deflection, robot, SPEED)))
        if np.hypot(*(truth.pose[:2] - ROUTE[-1])) < 0.25 and abs(truth.twist[0]) < 0.05:
            break
    done = np.array(rows)
    return done[:, 0], done[:, 1:4], done[:, 4:]


def no_people() -> Crowd:
    """Create a crowd of no people."""
    none = np.empty(0)
    return Crowd(
        position=none.reshape(0, 2),
        velocity=none.reshape(0, 2),
        heading=none,
        radius=none,
        preferred_speed=none,
        waypoints=none.reshape(0, 1, 2),
        target=np.empty(0, dtype=np.int64),
        loop=np.empty(0, dtype=bool),
        sees_robot=np.empty(0, dtype=bool),
    )


if __name__ == "__main__":
    main()
