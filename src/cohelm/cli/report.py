"""What the commands print: one JSON object, or tables for people."""

from __future__ import annotations

import json
import math
import platform
import sys
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text


class _Output(Console):
    """A console that leaves it to the command line what to do where nobody reads any more."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


ERRORS = Console(stderr=True, highlight=False)
OUTPUT = _Output(highlight=False, width=None if sys.stdout.isatty() else 120)

UNITS = {
    "time": "s",
    "path_length": "m",
    "path_length_short": "m",
    "min_distance": "m",
    "mean_distance": "m",
    "wall_distance": "m",
    "time_to_collision": "s",
    "social_space_intrusion": "s",
    "linear_velocity_variance": "m²/s²",
    "angular_velocity_variance": "rad²/s²",
    "linear_velocity_variance_underway": "m²/s²",
    "angular_velocity_variance_underway": "rad²/s²",
    "heading_change": "rad",
    "acceleration_max": "m/s²",
    "acceleration_rms": "m/s²",
    "jerk_max": "m/s³",
    "jerk_rms": "m/s³",
    "stalled_time": "s",
    "path_error": "m",
    "path_hausdorff": "m",
    "preference_distance": "m",
    "rider_reversals": "1/min",
}
"""Of the metrics that have one."""


def write_json(data: Mapping[str, Any]) -> None:
    """``data`` on standard output, on one line and nothing else."""
    sys.stdout.write(as_json(data) + "\n")


def as_json(data: Mapping[str, Any], indent: int | None = None) -> str:
    """JSON with sorted keys; NaN and infinities become null."""
    return json.dumps(_plain(data), sort_keys=True, allow_nan=False, indent=indent)


def versions() -> dict[str, str]:
    """Of cohelm, of Python and of what decides the numbers."""
    parts = ("cohelm", "daqp", "numba", "numpy", "opencv-python-headless", "scipy")
    return {**{part: version(part) for part in parts}, "python": platform.python_version()}


def metrics_table(title: str, metrics: Mapping[str, float], timing: Mapping[str, Any]) -> Table:
    """The metrics, and the tick's time, as a table."""
    table = Table(title=Text(title), title_justify="left", title_style="bold", header_style="dim")
    table.add_column("metric")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    for name, number in metrics.items():
        if math.isfinite(number):
            table.add_row(name, f"{number:.4g}", UNITS.get(name, ""))
    table.add_section()
    for stage in ("control", "tick"):
        if stage in timing:
            each = timing[stage]
            cells = " / ".join(f"{1e3 * each[k]:.2f}" for k in ("median", "p99", "max"))
            table.add_row(f"{stage} median / p99 / max", cells, "ms")
    if "tick" in timing:
        first = f"{1e3 * timing['tick']['first']:.2f}"
        table.add_row("first tick, with what was compiled for it", first, "ms")
    return table


def _plain(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {str(key): _plain(each) for key, each in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(each) for each in data]
    if hasattr(data, "tolist"):
        return _plain(data.tolist())
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data
