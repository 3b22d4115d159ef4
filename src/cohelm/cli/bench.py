"""``cohelm bench``: benchmarks as commands, their rows, tables and pictures in a folder."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn
from rich.progress import Progress as Bar
from rich.table import Table
from rich.text import Text

from cohelm.cli.report import ERRORS, OUTPUT, as_json, versions, write_json
from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Bench, Progress, Report, Sheet, run_tasks

INTERRUPTED = 130


class Asked(NamedTuple):
    """What the options say; None: what the benchmark says."""

    seeds: int | None
    """How many, from ``first`` on."""
    out: Path | None
    workers: int | None
    json: bool
    first: int = 0
    options: Mapping[str, Any] = MappingProxyType({})
    """What only this benchmark asks, for its ``on``; what is unset is not in it."""


def bench(name: str, module: str, asked: Asked) -> int:
    """Run a benchmark; returns 0, or 130 where it was interrupted and only part of it is there.

    Raises:
        ConfigError: if the folder cannot be written to.
    """
    found = import_module(module)
    chosen: Bench = found.on(**asked.options) if asked.options else found
    folder = _folder(asked.out or Path("benches") / name)
    seeds = chosen.SEEDS if asked.seeds is None else asked.seeds
    tasks = chosen.tasks(range(asked.first, asked.first + seeds))
    workers = asked.workers or chosen.WORKERS or os.cpu_count() or 1
    with _Bar(chosen.TITLE) as bar:
        results = run_tasks(chosen, tasks, folder, workers=workers, watch=bar)
    whole = bar.done == len(tasks)
    if not results:
        return INTERRUPTED
    report = chosen.report(results, folder)
    summary = {
        **report.summary,
        "bench": name,
        "complete": whole,
        "rows": [result.row for result in results],
        "versions": versions(),
    }
    (folder / "summary.json").write_text(as_json(summary, indent=2) + "\n", encoding="utf-8")
    if asked.json:
        write_json(summary)
    else:
        _say(chosen.TITLE, report, folder, whole=whole)
    return 0 if whole else INTERRUPTED


def _folder(folder: Path) -> Path:
    """The folder, made and found to be writable before the work begins."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "rows.csv").write_bytes(b"")
    except OSError as cause:
        raise ConfigError(
            f"{folder} is no folder to write to ({cause.strerror})", key="--out"
        ) from None
    return folder


def _say(title: str, report: Report, folder: Path, *, whole: bool) -> None:
    OUTPUT.print(Text(title, style="bold"))
    for sheet in report.sheets:
        if sheet.rows:
            OUTPUT.print(_table(sheet))
    for note in report.notes:
        OUTPUT.print(note, markup=False)
    if not whole:
        OUTPUT.print("interrupted: this is what was done by then", style="yellow")
    names = ["rows.csv", "summary.json", *(file.name for file in report.files)]
    OUTPUT.print(f"written to {folder}: {', '.join(names)}", markup=False, soft_wrap=True)


def _table(sheet: Sheet) -> Table:
    table = Table(title=Text(sheet.title), title_justify="left", header_style="dim")
    for i, column in enumerate(sheet.columns):
        table.add_column(column, justify="right" if i else "left", overflow="fold", no_wrap=not i)
    for row in sheet.rows:
        table.add_row(*row)
    return table


class _Bar:
    """The progress of a benchmark on a terminal."""

    def __init__(self, title: str) -> None:
        self.done = 0
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[left]}"),
            console=ERRORS,
            transient=True,
            disable=not ERRORS.is_terminal,
        )
        self._task = self._bar.add_task(title, total=None, left="")

    def __enter__(self) -> _Bar:
        self._bar.start()
        return self

    def __exit__(self, *what: Any) -> None:
        self._bar.stop()

    def __call__(self, progress: Progress) -> None:
        self.done = progress.done
        left = progress.left
        says = "compiling, riding …" if math.isnan(left) else f"about {_span(left)} left"
        self._bar.update(
            self._task, total=progress.total, completed=progress.done, left=says, refresh=True
        )


def _span(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
