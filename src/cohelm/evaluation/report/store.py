"""Ride tables on disk: ``episodes.parquet``, or ``rows.csv`` without pyarrow."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cohelm.errors import ConfigError
from cohelm.evaluation.report.rides import Rides, number
from cohelm.evaluation.sweeps.store import EPISODES, ROWS, read_size

_METADATA = b"cohelm"
_TEXT = frozenset({"outcome", "people_source", "config", "version", "error", "traceback", "replay",
                   "task", "command"})  # fmt: skip


def has_arrow() -> bool:
    """Check that pyarrow is installed, for Parquet."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 # an extra
    except ImportError:
        return False
    return True


def write_episodes(rides: Rides, file: Path) -> None:
    """Write all rides with all their columns, one row each, in their order.

    Columns of numbers are doubles or 64-bit integers, others text. NaN stays NaN, and a missing
    cell is null. The metadata of the file has the compared columns (``by``), as JSON under
    ``cohelm``.

    Raises:
        ImportError: without pyarrow.
        OSError: if the file cannot be written.
    """
    import pyarrow as pa  # noqa: PLC0415 # an extra
    import pyarrow.parquet as pq  # noqa: PLC0415 # an extra

    columns = list(dict.fromkeys(key for row in rides.rows for key in row))
    table = pa.table({key: _typed([row.get(key) for row in rides.rows]) for key in columns})
    metadata = {_METADATA: json.dumps({"by": rides.by}).encode()}
    part = file.with_suffix(".part")
    pq.write_table(table.replace_schema_metadata(metadata), part, compression="zstd")
    part.replace(file)


def part_of(count: int, folder: Path) -> str:
    """``14 of 36 rides`` where a folder has fewer rides than its sweep; else empty."""
    size = read_size(folder)
    return f"{count} of {size.rides} rides" if size is not None and count < size.rides else ""


def read_rides(folder: Path) -> Rides:
    """Read the rides of a result folder, or of one file.

    Raises:
        ConfigError: if there are none, or they cannot be read.
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
    import pyarrow.parquet as pq  # noqa: PLC0415 # an extra

    try:
        table = pq.read_table(file)
    except (OSError, pa.ArrowException) as cause:
        raise ConfigError(f"is not a readable Parquet file ({cause})", file=file) from None
    metadata = json.loads((table.schema.metadata or {}).get(_METADATA, b"{}"))
    names = table.column_names
    by = [str(each) for each in metadata.get("by", _before_seed(names, file))]
    return _checked(table.to_pylist(), by, names, file)


def _read_csv(file: Path) -> Rides:
    """Read a CSV file; columns of numbers become numbers, with NaN for an empty cell."""
    try:
        with file.open(newline="", encoding="utf-8") as stream:
            reader = csv.DictReader(stream)
            given, names = list(reader), list(reader.fieldnames or ())
    except (OSError, UnicodeDecodeError, csv.Error) as cause:
        raise ConfigError(f"is not a readable table ({cause})", file=file) from None
    by = _before_seed(names, file)
    numeric = {
        name
        for name in names
        if name not in by
        and name not in _TEXT
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
        what = ", ".join(sorted(missing)) or "compared columns"
        raise ConfigError(f"is not a table of rides: it lacks {what}", file=file)
    bad = [i for i, row in enumerate(rows) if not math.isfinite(number(row.get("seed")))]
    if bad:
        raise ConfigError(f"row {bad[0] + 1} has no seed", file=file)
    return Rides([{**row, "seed": int(number(row["seed"]))} for row in rows], by)


def _before_seed(names: Sequence[str], file: Path) -> list[str]:
    """Compared columns of a file without metadata: ``ride_row`` writes them before the seed."""
    if "seed" not in names:
        raise ConfigError("is not a table of rides: it lacks seed", file=file)
    return list(names[: list(names).index("seed")])


def _typed(cells: Sequence[Any]) -> Any:
    """Column of the one type that holds all its cells."""
    import pyarrow as pa  # noqa: PLC0415 # an extra

    given = [each for each in cells if each is not None]
    if given and all(isinstance(each, bool) for each in given):
        return pa.array(cells, pa.bool_())
    if given and all(isinstance(each, int) and not isinstance(each, bool) for each in given):
        return pa.array(cells, pa.int64())
    if given and all(isinstance(each, int | float) for each in given):
        return pa.array([None if c is None else float(c) for c in cells], pa.float64())
    return pa.array([None if c is None else _as_text(c) for c in cells], pa.string())


def _as_text(cell: Any) -> str:
    return json.dumps(cell) if isinstance(cell, Mapping | list | tuple) else str(cell)
