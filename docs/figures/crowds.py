"""Draw people of each pedestrian model: the picture of docs/crowds.md.

    python docs/figures/crowds.py

Above, one person walks past a standing chair, with each model; below, two groups pass each other,
and a third one stands and talks.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from cohelm.messages import Decision
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import Crowd, World

MODELS = ("orca", "social_force", "inattentive", "aggressive", "distracted")
PASSING = (
    "start=[7, 7, 0]",
    "goal=[12, 7]",
    "people.pedestrians=[{points: [[1.5, 6.8], [12.5, 6.8]], speed: 1.1}]",
    "people.jitter=0",
)
TOGETHER = (
    "start=[7, 1.5, 0]",
    "goal=[12, 1.5]",
    "people.groups=[{points: [[1.5, 6.5], [12.5, 6.5]], size: 3, speed: 1.1},"
    " {points: [[12.5, 7], [1.5, 7]], size: 2, speed: 1.2}, {points: [[7, 9.6]], size: 4}]",
)
COLOURS = ("#3d5a98", "#c2185b", "#0b7a75")


def main() -> None:
    """Draw the picture."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--plot", type=Path, default=Path("docs/images/crowds.png"))
    chosen = options.parse_args()
    figure = plt.figure(figsize=(9, 7.6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=[3, 2])
    axes = above.subplots(3, 2, sharex=True, sharey=True).ravel()
    for name, each in zip(MODELS, axes, strict=False):
        crowds = walked(name, PASSING, 16.0)
        draw(each, crowds, every=1.0)
        each.set_title(f"{name}", fontsize=9, loc="left", pad=2)
        each.set(xlim=(1.0, 13.0), ylim=(5.0, 8.6), aspect="equal")
        each.add_patch(Circle((7.0, 7.0), 0.55, facecolor="none", edgecolor="0.2", lw=1.2))
    axes[-1].set_axis_off()
    for name, each in zip(("orca", "social_force"), below.subplots(1, 2, sharey=True), strict=True):
        draw(each, walked(name, TOGETHER, 9.0), every=1.5)
        each.set_title(f"groups, {name}", fontsize=9, loc="left", pad=2)
        each.set(xlim=(1.0, 13.0), ylim=(5.0, 10.7), aspect="equal")
    for each in figure.axes:
        each.tick_params(labelsize=7)
        each.grid(alpha=0.25)
    figure.savefig(chosen.plot, dpi=85)


def walked(model: str, settings: tuple[str, ...], seconds: float) -> list[Crowd]:
    """Simulate people around a standing chair; returns them at every control step."""
    scenario = load_scenario("empty", [f"people.model={model}", *settings])
    setup = build_scenario(scenario, 0)
    world = World(setup.world, 0)
    crowds = [world.truth.crowd]
    for _ in range(round(seconds / setup.world.control_step)):
        world.advance(Decision(twist=np.zeros(3)))
        crowds.append(world.truth.crowd)
    return crowds


def draw(axes: Axes, crowds: list[Crowd], *, every: float) -> None:
    """Draw paths, and bodies at a time interval, later ones darker."""
    paths = np.array([crowd.position for crowd in crowds])
    group = crowds[0].group
    for i in range(paths.shape[1]):
        colour = COLOURS[0 if group is None else int(group[i]) % len(COLOURS)]
        axes.plot(*paths[:, i].T, color=colour, lw=1.0)
        shown = paths[:: round(every / 0.05), i]
        for k, place in enumerate(shown):
            alpha = 0.15 + 0.45 * (k + 1) / len(shown)
            axes.add_patch(Circle(tuple(place), 0.25, color=colour, alpha=alpha, lw=0))


if __name__ == "__main__":
    main()
