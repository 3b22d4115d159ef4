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
from typing import Any, Literal

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


def plain_table(*columns: str) -> Table:
    """A table whose first column is text and whose others are numbers; headings if any is given."""
    table = Table(header_style="dim", show_header=any(columns))
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", overflow="fold")
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

    The first column names the row. ``styles``: style of the cells with a certain text. ``width``:
    characters; None: those of the output.
    """
    texts = list(zip(columns, *rows, strict=True))
    least = [max(len(word) for text in each for word in ("", *text.split())) for each in texts]
    least[0] = max(map(len, texts[0]))  # never folds
    spare = (width or OUTPUT.width) - sum(least) - 3 * len(least) - 1
    widths = _widths(texts, least, spare)
    folds = [_lines(each[1:], size) for each, size in zip(texts, widths, strict=True)]
    if spare < 0 or max(folds) > _TALLEST:
        blocks = Table.grid("", "", padding=(0, 2))
        for row in rows:
            for heading, cell in zip(columns, row, strict=True):
                if cell:
                    blocks.add_row(Text(heading, "dim"), Text(cell, styles.get(cell, "")))
            blocks.add_row()
        return Group(Text(title, "italic"), blocks)
    table = Table(title=Text(title), title_justify="left", header_style="dim")
    for i, each in enumerate(texts):
        words = any(cell[:1].isalpha() for cell in each[1:])
        justify: Literal["left", "right"] = "left" if words else "right"
        table.add_column(each[0], justify=justify, no_wrap=not i, width=widths[i])
    for row in rows:
        table.add_row(*(Text(cell, styles.get(cell, "")) for cell in row))
    return table


def _widths(texts: Sequence[Sequence[str]], least: Sequence[int], spare: int) -> list[int]:
    """Minimum widths, plus spare width for the cells that fold most, then for the headings."""
    widths = list(least)
    for part in (slice(1, None), slice(1)):
        folds = [_lines(each[part], width) for each, width in zip(texts, widths, strict=True)]
        while spare > 0 and max(folds) > 1:
            i = folds.index(max(folds))
            widths[i] += 1
            spare -= 1
            folds[i] = _lines(texts[i][part], widths[i])
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
