"""The lines of the table of perception: what, its figure, what is wanted, whether that is met."""

from __future__ import annotations

import math
from typing import Any

from cohelm.recordings.outside import outside_data

MET, MISSED, NOT_RUN, SAID = "met", "MISSED", "not run", ""
Row = dict[str, Any]


def row(
    part: str,
    what: str,
    figure: float,
    *,
    unit: str = "",
    least: float | None = None,
    most: float | None = None,
    right: bool = True,
    remark: str = "",
) -> Row:
    """One line.

    Args:
        part: of the table.
        what: was measured.
        figure: that came of it; NaN fails whatever is wanted.
        unit: of the figure.
        least, most: what is wanted of it; None: nothing.
        right: whether all else that is wanted is as it should be.
        remark: of what, on what, with how many.
    """
    wanted = "" if least is None else f"≥ {least:g}"
    wanted = wanted if most is None else f"≤ {most:g}"
    met = right and (least is None or figure >= least) and (most is None or figure <= most)
    return {
        "part": part,
        "what": what,
        "figure": float(figure),
        "unit": unit,
        "wanted": wanted,
        "met": (MET if met else MISSED) if wanted else SAID,
        "remark": remark,
    }


def not_run(part: str, what: str, why: str) -> Row:
    """A line that says that something was not measured, and why."""
    return {**row(part, what, math.nan), "met": NOT_RUN, "remark": why}


def absent(*names: str) -> str:
    """Why a file of the outside data is not read."""
    if outside_data() is None:
        return "COHELM_DATA is not set; it names the folder of the outside data (cohelm data)"
    return f"{'/'.join(names)} is not in COHELM_DATA"
