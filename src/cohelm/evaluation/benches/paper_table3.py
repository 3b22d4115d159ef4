"""Table 3 of Xu et al., and our medians beside it, cell by cell.

What the paper leaves open is set here as in its scenes: distances are between surfaces, the time is
that to the first entry into 0.2 m of the goal, the length is counted on to the goal point, and the
variances are those of the ride until that moment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.bootstrap import Estimate, median_of
from cohelm.evaluation.results.rides import Rides

METHODS: Mapping[str, str] = {
    "mpc": "MPC",
    "mpc_dcbf": "MPC-DCBF",
    "social_mpc": "Socially-aware MPC",
    OURS: "SS-MPC-DCBF",
}
"""Our planner → the paper's method."""

Figures = tuple[float, float, float, float, float]

TABLE3: Mapping[str, Mapping[str, Figures]] = {
    "crossing": {
        "mpc": (0.0, 57.90, 12.147, 0.0585, 0.0852),
        "mpc_dcbf": (0.4898, 14.72, 10.171, 0.0627, 0.1799),
        "social_mpc": (0.8852, 15.53, 11.023, 0.0557, 0.2753),
        OURS: (0.2411, 16.89, 10.067, 0.0506, 0.0741),
    },
    "aggressive": {
        "mpc": (0.0, 32.90, 11.299, 0.0097, 0.1770),
        "mpc_dcbf": (0.5102, 14.84, 10.730, 0.0309, 0.3591),
        "social_mpc": (0.0, 19.76, 12.737, 0.0529, 0.9214),
        OURS: (0.5962, 15.05, 10.673, 0.0260, 0.2591),
    },
    "distracted": {
        "mpc": (0.0, 29.44, 10.698, 0.0079, 0.0752),
        "mpc_dcbf": (0.2857, 14.04, 10.122, 0.0298, 0.2369),
        "social_mpc": (0.2861, 15.88, 10.112, 0.0383, 0.1844),
        OURS: (0.3284, 13.755, 10.018, 0.0280, 0.0513),
    },
}
"""Scene → planner → what the paper prints, in the order of ``COLUMNS``; a gap of 0 is a hit."""


@dataclass(frozen=True)
class Column:
    """A measure of the table."""

    key: str
    """In a ride's row."""
    title: str
    unit: str
    digits: int
    better: int
    """The sign of what is better."""

    @property
    def head(self) -> str:
        """With its unit."""
        return f"{self.title}, {self.unit}"

    def worst(self, values: Floats) -> float:
        """Of values (k,); NaN of none."""
        there = values[np.isfinite(values)]
        if not len(there):
            return np.nan
        return float(there.min() if self.better > 0 else there.max())


COLUMNS = (
    Column("min_distance", "min distance", "m", 3, 1),
    Column("time", "time", "s", 2, -1),
    Column("path_length", "length", "m", 3, -1),
    Column("linear_velocity_variance_underway", "var v", "m²/s²", 4, -1),
    Column("angular_velocity_variance_underway", "var ω", "rad²/s²", 4, -1),
)
"""In the paper's order."""
CUT = tuple(
    replace(each, key="path_length_short", title="length to 0.3 m before the goal")
    if each.key == "path_length"
    else each
    for each in COLUMNS
)
"""The same with the length ended 0.3 m before the goal: the paper does not say where it ends."""
WHOLE = tuple(
    replace(each, key=each.key.removesuffix("_underway"), title=f"{each.title}, whole ride")
    if each.key.endswith("_underway")
    else each
    for each in COLUMNS
)
"""The same with the variances over the whole ride, until the chair stands at its goal."""
ENOUGH_CELLS = 13
"""Of 15, in which our medians are to be better than the paper's own."""


@dataclass(frozen=True)
class Cell:
    """One measure in one scene beside the paper's."""

    scene: str
    column: Column
    paper: float
    ours: Estimate
    """The median with its interval, over the rides that have the measure."""

    @property
    def won(self) -> bool:
        """Whether our median is better; one that there is not is not."""
        return bool(self.column.better * (self.ours.mean - self.paper) > 0.0)

    def __str__(self) -> str:
        ours = f"{self.ours.mean:.{self.column.digits}f}"
        return f"{self.scene}, {self.column.title} ({ours} against {self.paper:.5g})"


def values_of(group: Rides, column: Column) -> Floats:
    """Of each ride, (k,).

    The gap is that of all rides, 0 where a person was touched; all else NaN of who did not arrive.
    """
    values = group.column(column.key)
    if column.key == "min_distance":
        return values
    return np.where(group.reached, values, np.nan)


def median(group: Rides, column: Column) -> Estimate:
    """Of a measure, with its 95 % bootstrap interval."""
    return median_of(values_of(group, column))


def cells(
    rides: Mapping[str, Rides], columns: Sequence[Column] = COLUMNS, paper: str = OURS
) -> list[Cell]:
    """Every cell of the paper's table, scene by scene.

    Args:
        rides: scene → rides of one planner; scenes that the paper has not are left out.
        columns: what is compared, as many as the paper has, in its order.
        paper: whose row of the paper.
    """
    return [
        Cell(scene, column, figure, median(group, column))
        for scene, group in rides.items()
        if scene in TABLE3
        for column, figure in zip(columns, TABLE3[scene][paper], strict=True)
    ]
