"""Rides on disk: ``episodes.parquet`` with every column, and ``rows.csv`` where that is missing."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cohelm.errors import ConfigError
from cohelm.evaluation.results.rides import Rides, number
from cohelm.evaluation.sweeps.asked import read_asked

EPISODES, ROWS = "episodes.parquet", "rows.csv"
NO_ARROW = (
    f"{EPISODES} was not written: it needs pyarrow (pip install 'cohelm[results]'); "
    f"{ROWS} has the same rides"
)
_NOTES = b"cohelm"
_WORDS = frozenset(
    {"outcome", "people_from", "config", "version", "error", "traceback", "replay", "command"}
)


def has_arrow() -> bool:
    """Whether Parquet can be written and read here."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 # asked for
    except ImportError:
        return False
    return True


def write_episodes(rides: Rides, file: Path) -> None:
    """All rides with all their columns; one row each, in their order.

    Columns of numbers are doubles or 64-bit integers, others text; NaN stays NaN, and what a row
    does not have is null. The file's metadata names what was compared (``by``), as JSON under
    ``cohelm``.

    Raises:
        ImportError: without pyarrow.
        OSError: if the file cannot be written.
    """
    import pyarrow as pa  # noqa: PLC0415 # an extra
    import pyarrow.parquet as pq  # noqa: PLC0415

    columns = list(dict.fromkeys(key for row in rides.rows for key in row))
    table = pa.table({key: _typed([row.get(key) for row in rides.rows]) for key in columns})
    notes = json.dumps({"by": rides.by}).encode()
    beside = file.with_suffix(".part")
    pq.write_table(table.replace_schema_metadata({_NOTES: notes}), beside, compression="zstd")
    beside.replace(file)


def rides_asked(folder: Path) -> int | None:
    """How many rides the sweep in a folder was to have; None where nothing says it."""
    asked = read_asked(folder)
    return asked.rides if asked is not None and asked.rides else None


def part_of(many: int, folder: Path) -> str:
    """``14 of 36 rides`` where a folder has less than was asked for; else empty."""
    asked = rides_asked(folder)
    return f"{many} of {asked} rides" if asked is not None and many < asked else ""


def read_rides(folder: Path) -> Rides:
    """The rides of a result folder, or of a file of them; columns as they were written.

    Raises:
        ConfigError: if there are none, or what is there cannot be read.
    """
    if not folder.exists():
        raise ConfigError("does not exist", file=folder)
    parquet, rows = folder / EPISODES, folder / ROWS
    if folder.is_file():
        parquet, rows = (folder, rows) if folder.suffix == ".parquet" else (parquet, folder)
    if parquet.is_file() and (has_arrow() or not rows.is_file()):
        return _read_parquet(parquet)
    if rows.is_file():
        return _read_csv(rows)
    raise ConfigError(
        f"has neither {EPISODES} nor {ROWS}; give the folder that cohelm bench wrote to",
        file=folder,
    )


def _read_parquet(file: Path) -> Rides:
    if not has_arrow():
        raise ConfigError("reading it needs pyarrow: pip install 'cohelm[results]'", file=file)
    import pyarrow as pa  # noqa: PLC0415 # an extra
    import pyarrow.parquet as pq  # noqa: PLC0415

    try:
        table = pq.read_table(file)
    except (OSError, pa.ArrowException) as cause:
        raise ConfigError(f"is no Parquet file that can be read ({cause})", file=file) from None
    notes = json.loads((table.schema.metadata or {}).get(_NOTES, b"{}"))
    names = table.column_names
    by = [str(each) for each in notes.get("by", _before_seed(names, file))]
    return _checked(table.to_pylist(), by, names, file)


def _read_csv(file: Path) -> Rides:
    """Columns in which everything is a number become numbers, an empty cell of them NaN."""
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            given, names = list(reader), list(reader.fieldnames or ())
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise ConfigError(f"cannot be read as a table ({cause})", file=file) from None
    by = _before_seed(names, file)
    numeric = {
        name
        for name in names
        if name not in by
        and name not in _WORDS
        and all(not row[name] or math.isfinite(number(row[name])) for row in given)
    }
    rows = [
        {key: number(each) if key in numeric else each for key, each in row.items()}
        for row in given
    ]
    return _checked(rows, by, names, file)


def _checked(rows: list[dict[str, Any]], by: list[str], names: Sequence[str], file: Path) -> Rides:
    missing = {"seed", "outcome", *by} - set(names)
    if missing or not by:
        what = ", ".join(sorted(missing)) or "what was compared"
        raise ConfigError(f"is no table of rides: it lacks {what}", file=file)
    bad = [i for i, row in enumerate(rows) if not math.isfinite(number(row.get("seed")))]
    if bad:
        raise ConfigError(f"row {bad[0] + 1} has no seed", file=file)
    return Rides([{**row, "seed": int(number(row["seed"]))} for row in rows], by)


def _before_seed(names: Sequence[str], file: Path) -> list[str]:
    """What was compared, where nothing says it: ``ride_row`` puts it before the seed."""
    if "seed" not in names:
        raise ConfigError("is no table of rides: it lacks seed", file=file)
    return list(names[: list(names).index("seed")])


def _typed(cells: Sequence[Any]) -> Any:
    """A column with the one type that holds all its cells."""
    import pyarrow as pa  # noqa: PLC0415 # an extra

    given = [each for each in cells if each is not None]
    if given and all(isinstance(each, bool) for each in given):
        return pa.array(cells, pa.bool_())
    if given and all(_is_whole(each) for each in given):
        return pa.array([None if c is None else int(c) for c in cells], pa.int64())
    if given and all(_is_whole(each) or isinstance(each, float | bool) for each in given):
        return pa.array([None if c is None else float(c) for c in cells], pa.float64())
    return pa.array([None if c is None else _as_text(c) for c in cells], pa.string())


def _is_whole(cell: Any) -> bool:
    return isinstance(cell, int) and not isinstance(cell, bool)


def _as_text(cell: Any) -> str:
    return json.dumps(cell) if isinstance(cell, Mapping | list | tuple) else str(cell)
