"""Output of the commands: one JSON object, or tables for people."""

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


class _Output(Console):
    """A console that leaves a broken pipe to the command line."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


ERRORS = Console(stderr=True, highlight=False)
OUTPUT = _Output(highlight=False, width=None if sys.stdout.isatty() else 120)


def write_json(data: Mapping[str, Any]) -> None:
    """Write ``data`` to standard output, on one line."""
    sys.stdout.write(as_json(data) + "\n")


def as_json(data: Mapping[str, Any], indent: int | None = None) -> str:
    """JSON with sorted keys; NaN and infinities become null."""
    return json.dumps(_plain(data), sort_keys=True, allow_nan=False, indent=indent)


def print_line(text: str) -> None:
    """Print one line as it is, without markup and without folding."""
    OUTPUT.print(text, markup=False, soft_wrap=True)


def plain_table(*columns: str, right: bool = True) -> Table:
    """A table whose first column is text and whose others are numbers, without frames.

    Args:
        columns: headings; all empty: none is shown.
        right: align all but the first column to the right.
    """
    table = Table(header_style="dim", show_header=any(columns))
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if right and i else "left", overflow="fold")
    return table


def versions() -> dict[str, str]:
    """Versions of cohelm, of Python and of the libraries that decide the numbers."""
    parts = ("cohelm", "daqp", "numba", "numpy", "opencv-python-headless", "scipy")
    return {**{part: version(part) for part in parts}, "python": platform.python_version()}


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
