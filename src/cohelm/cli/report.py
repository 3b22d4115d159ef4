"""Output of the commands: one JSON object, or tables for people."""

from __future__ import annotations

import json
import math
import platform
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from types import MappingProxyType
from typing import Any

from rich.console import Console, Group
from rich.table import Table
from rich.text import Text


class _Output(Console):
    """A console that leaves a broken pipe to the command line."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


_TALLEST = 5
"""Maximum number of lines of a cell; beyond it a row becomes a block."""

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


def fitted_table(
    title: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    styles: Mapping[str, str] = MappingProxyType({}),
    width: int | None = None,
) -> Table | Group:
    """A table that folds between words; a block for each row where it would be too wide for that.

    Args:
        title: above the table.
        columns: headings; the first column names the row.
        rows: cells.
        styles: style of the cells with a certain text.
        width: characters; None: those of the output.
    """
    texts = list(zip(columns, *rows, strict=True))
    longest = [max(len(word) for text in each for word in ("", *text.split())) for each in texts]
    longest[0] = max(map(len, texts[0]))  # never folds
    spare = (width or OUTPUT.width) - sum(longest) - 3 * len(longest) - 1
    widths = _widths(columns, rows, longest, spare)
    cells = [[Text(cell, styles.get(cell, "")) for cell in row] for row in rows]
    folds = (_lines(each[1:], size) for each, size in zip(texts, widths, strict=True))
    if spare < 0 or max(folds) > _TALLEST:
        return Group(Text(title, "italic"), _blocks(columns, cells))
    table = Table(title=Text(title), title_justify="left", header_style="dim")
    for i, (column, size) in enumerate(zip(columns, widths, strict=True)):
        words = any(cell[:1].isalpha() for cell in texts[i][1:])
        table.add_column(column, justify="left" if words else "right", no_wrap=not i, width=size)
    for row in cells:
        table.add_row(*row)
    return table


def _blocks(columns: Sequence[str], rows: Iterable[Sequence[Text]]) -> Table:
    """Each row as lines of heading and cell."""
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for name, *cells in rows:
        table.add_row(columns[0], Text(name.plain, "bold"))
        for heading, cell in zip(columns[1:], cells, strict=True):
            if cell:
                table.add_row(heading, cell)
        table.add_row()
    return table


def _widths(
    columns: Sequence[str], rows: Sequence[Sequence[str]], least: Sequence[int], spare: int
) -> list[int]:
    """Minimum widths, plus spare width for the cells that fold most, then for the headings."""
    widths = list(least)
    for lines in (rows, (columns,)):
        texts = [{row[i] for row in lines} for i in range(len(widths))]
        folds = [_lines(each, width) for each, width in zip(texts, widths, strict=True)]
        while spare > 0 and max(folds) > 1:
            i = folds.index(max(folds))
            widths[i] += 1
            spare -= 1
            folds[i] = _lines(texts[i], widths[i])
    return widths


def _lines(cells: Iterable[str], width: int) -> int:
    """Number of lines of the cell that folds most."""
    folded = textwrap.TextWrapper(max(width, 1), break_on_hyphens=False)
    return max((len(folded.wrap(cell)) for cell in cells), default=0)


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
