"""Table 3 of Xu et al., what the paper concludes from it, and our medians cell by cell.

What the paper leaves open is fixed here as in its scenes: distances are between surfaces, the time
is that of the first entry into 0.2 m of the goal, the length is extended to the goal point, and
the variances are those of the ride until that moment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cohelm.benchmarks.claims import (
    NONE,
    OURS,
    SOME,
)
from cohelm.benchmarks.ride_claims import (
    Claim,
    Ordering,
    Requirement,
    between,
    within,
)
from cohelm.benchmarks.rides.cases import DYNAMIC
from cohelm.evaluation.report.rides import Rides, Row
from cohelm.evaluation.report.statistics import Estimate, bootstrap_median

SOURCE = "Xu et al., Table 3"
METHODS: Mapping[str, str] = {
    "mpc": "MPC",
    "mpc_dcbf": "MPC-DCBF",
    "social_mpc": "Socially-aware MPC",
    OURS: "SS-MPC-DCBF",
}
"""Our planner → the paper's method."""

TABLE3: Mapping[str, Mapping[str, tuple[float, float, float, float, float]]] = {
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
"""Scene → planner → printed figures in the order of ``COLUMNS``; a distance of 0 is a collision."""


@dataclass(frozen=True)
class PaperColumn:
    """A column of the table."""

    key: str
    """Column of a ride's row."""
    title: str
    unit: str
    digits: int
    better: int
    """1: more is better, −1: less."""

    @property
    def head(self) -> str:
        """Title with its unit."""
        return f"{self.title}, {self.unit}"

    def worst(self, values: Any) -> float:
        """Worst of values (k,); NaN where there are none."""
        there = values[np.isfinite(values)]
        if not len(there):
            return np.nan
        return float(there.min() if self.better > 0 else there.max())


COLUMNS = (
    PaperColumn("min_distance", "min distance", "m", 3, 1),
    PaperColumn("time", "time", "s", 2, -1),
    PaperColumn("path_length", "length", "m", 3, -1),
    PaperColumn("linear_velocity_variance_underway", "var v", "m²/s²", 4, -1),
    PaperColumn("angular_velocity_variance_underway", "var ω", "rad²/s²", 4, -1),
)
"""Columns in the paper's order."""
CUT = tuple(
    replace(each, key="path_length_short", title="length to 0.3 m before the goal")
    if each.key == "path_length"
    else each
    for each in COLUMNS
)
"""Columns with the length ended 0.3 m before the goal: the paper does not define its end."""
WHOLE = tuple(
    replace(each, key=each.key.removesuffix("_underway"), title=f"{each.title}, whole ride")
    if each.key.endswith("_underway")
    else each
    for each in COLUMNS
)
"""Columns with the variances over the whole ride, until the chair stands at its goal."""
ENOUGH_CELLS = 13
"""Cells, of 15, in which our medians have to be better than the paper's."""


@dataclass(frozen=True)
class Cell:
    """One measure in one scene beside the paper's figure."""

    scene: str
    column: PaperColumn
    paper: float
    ours: Estimate
    """Median with its interval, over the rides that have the measure."""

    @property
    def won(self) -> bool:
        """True where our median is better; a missing one is not."""
        return bool(self.column.better * (self.ours.mean - self.paper) > 0.0)

    def __str__(self) -> str:
        ours = f"{self.ours.mean:.{self.column.digits}f}"
        return f"{self.scene}, {self.column.title} ({ours} against {self.paper:.5g})"


def arrived_only(row: Row) -> dict[str, Any]:
    """Row in which only a ride that arrived has time, length and variances; NaN otherwise.

    The minimum distance stays that of every ride, 0 at a collision with a person.
    """
    if row["outcome"] == "reached":
        return dict(row)
    keys = {column.key for column in (*COLUMNS, *CUT, *WHOLE)} - {"min_distance"}
    return {**row, **dict.fromkeys(keys & row.keys(), np.nan)}


def cells(
    rides: Mapping[str, Rides], columns: Sequence[PaperColumn] = COLUMNS, paper: str = OURS
) -> list[Cell]:
    """Every cell of the paper's table, scene by scene.

    Args:
        rides: scene → rides of one planner; scenes that the paper lacks are left out.
        columns: as many as the paper has, in its order.
        paper: row of the paper.
    """
    return [
        Cell(scene, column, figure, bootstrap_median(group.column(column.key)))
        for scene, group in rides.items()
        if scene in TABLE3
        for column, figure in zip(columns, TABLE3[scene][paper], strict=True)
    ]


_RIVALS = ("mpc", "mpc_dcbf", "social_mpc")
_AVOIDING = ("mpc_dcbf", "social_mpc")
_GAP, _TIME, _LENGTH, _VAR_V, _VAR_W = (column.key for column in COLUMNS)


def _touches(planner: str, scenes: tuple[str, ...], text: str, *, touches: bool) -> Requirement:
    bound = SOME if touches else NONE
    return Requirement("person_contacts", bound, scenes, planner, source=SOURCE, text=text)


CLAIMS: tuple[Claim, ...] = (
    Ordering("SS-MPC-DCBF drives the shortest path in all three scenes",
             (_LENGTH,), -1, within(DYNAMIC, OURS, _RIVALS), SOURCE),
    Ordering("SS-MPC-DCBF's speed varies less than that of both others that avoid people",
             (_VAR_V,), -1, within(DYNAMIC, OURS, _AVOIDING), SOURCE),
    Ordering("SS-MPC-DCBF's turn rate varies less than that of both others that avoid people",
             (_VAR_W,), -1, within(DYNAMIC, OURS, _AVOIDING), SOURCE),
    _touches(OURS, DYNAMIC, "SS-MPC-DCBF never collides in all three scenes", touches=False),
    _touches("mpc", DYNAMIC, "MPC, which does not predict, collides in all three scenes",
             touches=True),
    _touches("mpc_dcbf", DYNAMIC, "MPC-DCBF never collides in all three scenes",
             touches=False),
    Ordering("MPC-DCBF, which knows no social space, passes aggressive and distracted people "
             "nearer than SS-MPC-DCBF", (_GAP,), -1,
             within(("aggressive", "distracted"), "mpc_dcbf", (OURS,)), SOURCE),
    Ordering("Socially-aware MPC keeps the largest distance in crossing",
             (_GAP,), 1, within(("crossing",), "social_mpc", ("mpc", "mpc_dcbf", OURS)), SOURCE),
    _touches("social_mpc", ("aggressive",), "Socially-aware MPC collides in aggressive",
             touches=True),
    Ordering("Socially-aware MPC is less smooth in crossing and aggressive than in distracted",
             (_VAR_V, _VAR_W), 1,
             between("social_mpc", ("crossing", "aggressive"), "distracted"), SOURCE),
    Ordering("MPC-DCBF is the fastest in crossing and aggressive", (_TIME,), -1,
             within(("crossing", "aggressive"), "mpc_dcbf", ("mpc", "social_mpc", OURS)), SOURCE),
    Ordering("SS-MPC-DCBF is the fastest in distracted", (_TIME,), -1,
             within(("distracted",), OURS, _RIVALS), SOURCE),
    Ordering("MPC is the slowest in all three scenes", (_TIME,), 1,
             within(DYNAMIC, "mpc", ("mpc_dcbf", "social_mpc", OURS)), SOURCE),
)  # fmt: skip
"""Everything that Table 3 and the sentences about it order."""
