"""Pictures of a plan among people, and of its barrier values along the plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Floats
from cohelm.control import LocalProblem
from cohelm.geometry import transform
from cohelm.messages import LocalPlan
from cohelm.plotting import canvas
from cohelm.shapes import hull_outline, outline

COLOURS = ("#1d2530", "#c23b3b", "#2e9e4f", "#3d6fb4", "#8f5cc3")
MARKS = ("o", "s", "^", "D", "v")
_BINDS = 0.01
"""Margin below which a row is active, m."""
_OUTLINE = 72


@dataclass(frozen=True)
class Barrier:
    """One series of barrier values along a plan."""

    name: str
    h: Floats
    """(N+1,) m."""
    gamma: float


def draw_barriers(
    problem: LocalProblem,
    plan: LocalPlan,
    barriers: Sequence[Barrier],
    file: Path,
    *,
    shown: Sequence[int],
) -> None:
    """Draw the plan with people at ``shown`` steps, and h along the plan.

    A filled mark is an active row: h falls as fast as γ allows, or faster with slack.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure = Figure(figsize=(9.6, 3.9), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
    _draw_plan(left, problem, plan, shown)
    _draw_values(right, barriers, plan.step)
    canvas.save(figure, file)


def _draw_plan(axes: Axes, problem: LocalProblem, plan: LocalPlan, shown: Sequence[int]) -> None:
    reference, spaces = problem.reference.poses, problem.spaces
    axes.plot(reference[:, 0], reference[:, 1], color=canvas.PLAIN_ROUTE, lw=1.2, ls=(0, (4, 3)))
    axes.plot(plan.poses[:, 0], plan.poses[:, 1], color=canvas.ROUTE, lw=2.0)
    for place, k in enumerate(shown):
        strength = 0.35 + 0.65 * place / max(len(shown) - 1, 1)
        chair = transform(plan.poses[k], problem.robot.outline)
        axes.fill(*chair.T, fill=False, ec=canvas.CHAIR, lw=1.3, alpha=strength)
        axes.annotate(
            f"{k * plan.step:.1f} s",
            (float(plan.poses[k, 0]), float(plan.poses[k, 1])),
            ha="center",
            va="center",
            fontsize=6.5,
        )
        for i, mean in enumerate(problem.predictions.mean[:, 0, k]):
            pose = np.array([*mean, spaces.axis[i, 0, k]])
            egg = outline(spaces.shape(i, 0, k), float(problem.people.radius[i]), pose, _OUTLINE)
            body = problem.people.radius[i] * _circle() + mean
            axes.plot(*egg.T, color=canvas.SPACE, lw=1.0, alpha=strength)
            axes.fill(*body.T, fc=canvas.PERSON, ec="none", alpha=0.6 * strength)
        if spaces.groups is not None and place == 0:
            for support in spaces.groups.support[:, k]:
                ring = hull_outline(spaces.groups.direction, support)
                axes.plot(*ring.T, color=canvas.GROUP, lw=1.2, ls=canvas.HULL)
    axes.set(aspect="equal", xlabel="m")
    axes.tick_params(labelsize=7)


def _circle() -> Floats:
    angle = np.linspace(0.0, 2.0 * np.pi, _OUTLINE)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _draw_values(axes: Axes, barriers: Sequence[Barrier], step: float) -> None:
    axes.axhline(0.0, color="#9aa3ad", lw=0.8)
    for i, each in enumerate(barriers):
        colour, mark = COLOURS[i % len(COLOURS)], MARKS[i % len(MARKS)]
        times = step * np.arange(len(each.h))
        margin = each.h[1:] - (1.0 - each.gamma) * each.h[:-1]
        binds = np.concatenate([[False], margin < _BINDS])
        axes.plot(times, each.h, color=colour, lw=1.3, label=f"{each.name}, γ = {each.gamma:g}")
        axes.plot(times[~binds], each.h[~binds], mark, color=colour, mfc="white", ms=3.5)
        axes.plot(times[binds], each.h[binds], mark, color=colour, ms=5.0)
    axes.set_xlabel("time ahead, s")
    axes.set_ylabel("h, m")
    axes.tick_params(labelsize=7)
    axes.legend(frameon=False, fontsize=7.5)
