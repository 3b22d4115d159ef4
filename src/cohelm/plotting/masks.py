"""Draw filter masks: keepout zones hatched, speed zones tinted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.transforms import Affine2D, Transform

from cohelm.arrays import Booleans, Floats
from cohelm.maps import CostmapFilter
from cohelm.maps.masks import CLOSED
from cohelm.planning import RouteProblem

KEEPOUT = "#6a3d9a"
SLOW = "#2f7fc1"
_CELLS = 500
"""Number of cells along the longer side in which a keepout zone is outlined."""


def draw_masks(axes: Axes, problem: RouteProblem) -> None:
    """Draw the keepout zones and the speed zones of a problem."""
    window = (*axes.get_xlim(), *axes.get_ylim())
    closed, shares = False, list[float]()
    for mask in problem.filters:
        if mask.type == "keepout":
            closed = _draw_closed(axes, mask) or closed
        else:
            shares += _draw_slow(axes, mask, problem.robot.max_speed)
    axes.set(xlim=window[:2], ylim=window[2:])
    if closed:
        axes.fill(
            [], [], facecolor=to_rgba(KEEPOUT, 0.12), edgecolor=KEEPOUT, hatch="\\\\\\\\",
            label="keepout zone",
        )  # fmt: skip
    if shares:
        low, high = (f"{100.0 * share:.0f}" for share in (min(shares), max(shares)))
        label = f"slow: {low if low == high else f'{low} to {high}'} % of full speed"
        axes.fill([], [], facecolor=to_rgba(SLOW, 0.22), edgecolor=SLOW, label=label)


def _draw_closed(axes: Axes, mask: CostmapFilter) -> bool:
    """Draw the cells where a mask is closed; return True if there are any."""
    closed = _numbers(mask) >= CLOSED
    if not closed.any():
        return False
    step = math.ceil(max(closed.shape) / _CELLS)
    coarse = np.pad(_pooled(closed, step), 1).astype(float)
    side = step * mask.mask.resolution
    rows, cols = coarse.shape
    x, y = (np.arange(cols) - 0.5) * side, (np.arange(rows) - 0.5) * side
    style: dict[str, Any] = {
        "levels": [0.5, 1.5],
        "transform": _to_map(mask) + axes.transData,
        "zorder": 2,
    }
    areas = axes.contourf(
        x, y, coarse, colors=[to_rgba(KEEPOUT, 0.12)], hatches=["\\\\\\\\"], **style
    )
    areas.set_edgecolor(to_rgba(KEEPOUT, 0.6))
    areas.set_linewidth(0.0)
    axes.contour(x, y, coarse, colors=[KEEPOUT], linewidths=1.2, **style)
    return True


def _draw_slow(axes: Axes, mask: CostmapFilter, full_speed: float) -> list[float]:
    """Draw the cells where a mask limits the speed, darker if slower; return the limits, 0…1."""
    shares = _numbers(mask) / (100.0 if mask.type == "speed_percent" else full_speed)
    limited = (shares > 0.0) & (shares < 1.0)
    if not limited.any():
        return []
    tint = np.zeros((*shares.shape, 4))
    tint[..., :3] = to_rgba(SLOW)[:3]
    tint[..., 3] = np.where(limited, 0.28 - 0.2 * shares, 0.0)
    width, height = mask.mask.size
    axes.imshow(
        tint, origin="lower", extent=(0.0, width, 0.0, height), interpolation="nearest",
        transform=_to_map(mask) + axes.transData, zorder=0.5,
    )  # fmt: skip
    return [float(shares[limited].min()), float(shares[limited].max())]


def _numbers(mask: CostmapFilter) -> Floats:
    """Numbers of the mask (rows, cols); 0 where it has no effect."""
    numbers: Floats = np.where(
        mask.mask.data < 0, 0.0, mask.base + mask.multiplier * mask.mask.data
    )
    return numbers


def _pooled(cells: Booleans, step: int) -> Booleans:
    """Pool cells: True where any cell of a square of ``step`` cells is set."""
    rows, cols = (math.ceil(n / step) * step for n in cells.shape)
    padded = np.zeros((rows, cols), dtype=bool)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    squares = padded.reshape(rows // step, step, cols // step, step)
    return np.asarray(squares.any(axis=(1, 3)))


def _to_map(mask: CostmapFilter) -> Transform:
    x, y, heading = mask.mask.X_MG.tolist()
    return Affine2D().rotate(heading).translate(x, y)
