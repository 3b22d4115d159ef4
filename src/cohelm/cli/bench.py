"""``cohelm bench``: benchmarks as commands, their rows, tables and pictures in a folder."""

from __future__ import annotations

import os
import tempfile
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rich.table import Table
from rich.text import Text

from cohelm.cli.bench_progress import Bar
from cohelm.cli.report import ERRORS, OUTPUT, as_json, versions, write_json
from cohelm.cli.said import said
from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Bench, Report, Sheet, Task
from cohelm.evaluation.sweeps.executors import executor_for
from cohelm.evaluation.sweeps.identity import check_plain, code, options_of
from cohelm.evaluation.sweeps.ledger import Header, Ledger, check_new
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.sweep import Sweep, sweep

FAILED, INTERRUPTED = 1, 130


class Asked(NamedTuple):
    """What the options say; None: what the benchmark says."""

    seeds: int | None = None
    """How many, from ``first`` on."""
    out: Path | None = None
    workers: int | None = None
    json: bool = False
    first: int = 0
    options: Mapping[str, Any] = MappingProxyType({})
    """What only this benchmark asks, for its ``on``; what is unset is not in it."""
    resume: bool = False
    overwrite: bool = False
    cluster: str | None = None
    """``local`` or the address of a scheduler; None: processes here."""


def bench(name: str, module: str, asked: Asked) -> int:
    """Run a benchmark; returns 0, 1 where tasks failed, 130 where it was interrupted.

    Raises:
        ConfigError: if the folder cannot be written to, has results that are neither to be gone on
            with nor to be thrown away, or is of another sweep.
        WorkersFailed: if there are no workers, or not the right ones.
    """
    done, report = run_bench(name, module, asked)
    if report is not None and asked.json:
        write_json(_summary(name, done, report))
    return INTERRUPTED if not done.whole else FAILED if done.faults or report is None else 0


def run_bench(name: str, module: str, asked: Asked) -> tuple[Sweep, Report | None]:
    """Run a benchmark, write what it found and, but for JSON, say it; raises as :func:`bench`.

    Returns:
        what came of the tasks, and what it says; None where it is too little to say anything.
    """
    chosen, tasks, workers = _planned(module, asked)
    folder = _folder(asked.out or Path("benches") / name, asked)
    header = Header(bench=name, options=options_of(chosen), code=code())
    with executor_for(asked.cluster, workers) as executor:
        begun = Ledger(folder, header, resume=asked.resume, overwrite=asked.overwrite)
        with begun as ledger, Bar(name) as bar:
            done = sweep(chosen, tasks, folder, executor=executor, ledger=ledger, watch=bar)
    notes = (*_faults(done), *_changed(ledger))
    report = _report(chosen, done, folder)
    if report is None:
        for note in notes:
            ERRORS.print(note, markup=False, soft_wrap=True)
        return done, None
    report = replace(report, notes=(*report.notes, *notes))
    text = as_json(_summary(name, done, report), indent=2)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8")
    if not asked.json:
        _say(chosen.TITLE, report, folder, done)
    return done, report


def _summary(name: str, done: Sweep, report: Report) -> Mapping[str, Any]:
    return {
        **report.summary,
        "bench": name,
        "complete": done.whole,
        "tasks": {"done": done.done, "total": done.total},
        "failures": [{"task": i, **asdict(fault)} for i, fault in done.faults.items()],
        "rows": [result.row for result in done.results],
        "versions": versions(),
    }


def _planned(module: str, asked: Asked) -> tuple[Bench, Sequence[Task], int]:
    """The benchmark as asked for, its tasks, and how many processes do them."""
    chosen: Bench = import_module(module).on(**asked.options)
    seeds = chosen.SEEDS if asked.seeds is None else asked.seeds
    tasks = chosen.tasks(range(asked.first, asked.first + seeds))
    check_plain(tasks)
    _check_apart(tasks)
    return chosen, tasks, asked.workers or chosen.WORKERS or os.cpu_count() or 1


def _check_apart(tasks: Sequence[Task]) -> None:
    """Of two files of one name the tables would make one; they are refused.

    Raises:
        ConfigError: if two rides differ in nothing that their rows say.
    """
    known: dict[tuple[object, int], RideTask] = {}
    for ride in (each for task in tasks for each in task if isinstance(each, RideTask)):
        other = known.setdefault((ride.columns, ride.seed), ride)
        if other.scenario != ride.scenario or other.settings != ride.settings:
            name = ", ".join(word for _, word in ride.columns)
            raise ConfigError(
                f"two different rides are called {name!r}, seed {ride.seed}; give files names "
                "that differ"
            )


def _folder(folder: Path, asked: Asked) -> Path:
    """The folder, made and found to be writable before the work begins."""
    if asked.resume and asked.overwrite:
        raise ConfigError("goes on with what --overwrite throws away", key="--resume")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as cause:
        raise ConfigError(
            f"{folder} is no folder to write to ({cause.strerror})", key="--out"
        ) from None
    if not (asked.resume or asked.overwrite):
        check_new(folder)  # and once more when nobody else can write to it
    return folder


def _report(chosen: Bench, done: Sweep, folder: Path) -> Report | None:
    """What the results say; None where there are too few for it, which is said."""
    if not done.results:
        return None
    try:
        with said():
            return chosen.report(done.results, folder)
    except Exception as failure:
        if done.whole and not done.faults:
            raise
        text = f"no report comes of a part ({type(failure).__name__}: {failure})"
        ERRORS.print(f"{text}; {folder} keeps it, and --resume goes on", markup=False)
        return None


def _faults(done: Sweep) -> list[str]:
    """Failed tasks, those of one kind together."""
    kinds: dict[str, list[int]] = {}
    for index, fault in done.faults.items():
        kinds.setdefault(fault.error, []).append(index)
    return [
        f"FAILED: {len(each)} of {done.total} tasks, the first number {each[0]}: {error}"
        for error, each in kinds.items()
    ]


def _changed(ledger: Ledger) -> list[str]:
    if not ledger.changed:
        return []
    return [f"ridden before the code was changed ({ledger.changed})"]


def _say(title: str, report: Report, folder: Path, done: Sweep) -> None:
    OUTPUT.print(Text(title, style="bold"))
    for sheet in report.sheets:
        if sheet.rows:
            OUTPUT.print(_table(sheet))
    for note in report.notes:
        OUTPUT.print(note, markup=False)
    if not done.whole:
        says = f"interrupted: this is a part, {done.done} of {done.total} tasks; --resume goes on"
        OUTPUT.print(says, style="yellow")
    names = ["rows.csv", "summary.json", *(file.name for file in report.files)]
    OUTPUT.print(f"written to {folder}: {', '.join(names)}", markup=False, soft_wrap=True)


def _table(sheet: Sheet, width: int | None = None) -> Table:
    """A sheet of which no column cuts a word of its head in two, where ``width`` has room for it.

    A table that is too wide is cut off at its right, which is worse.
    """
    longest = [max(map(len, column.split()), default=0) for column in sheet.columns]
    longest[0] = max(len(row[0]) for row in (sheet.columns, *sheet.rows))  # is never folded
    spare = (width or OUTPUT.width) - sum(longest) - 3 * len(longest) - 1
    widths = _widths(sheet, longest, spare)
    table = Table(title=Text(sheet.title), title_justify="left", header_style="dim")
    for i, column in enumerate(sheet.columns):
        table.add_column(
            column,
            justify="right" if i else "left",
            overflow="fold",
            no_wrap=not i,
            width=widths[i] if spare >= 0 else None,
        )
    for row in sheet.rows:
        table.add_row(*row)
    return table


def _widths(sheet: Sheet, least: Sequence[int], spare: int) -> list[int]:
    """The least widths, and what is spare given to the cells folded most, then to the heads."""
    widths = list(least)
    for lines in (sheet.rows, (sheet.columns,)):
        columns = [{row[i] for row in lines} for i in range(len(widths))]
        folds = [_lines(column, width) for column, width in zip(columns, widths, strict=True)]
        while spare > 0 and max(folds) > 1:
            i = folds.index(max(folds))
            widths[i] += 1
            spare -= 1
            folds[i] = _lines(columns[i], widths[i])
    return widths


def _lines(cells: Iterable[str], width: int) -> int:
    """Of the cell that is folded most."""
    folded = textwrap.TextWrapper(max(width, 1), break_on_hyphens=False)
    return max((len(folded.wrap(cell)) for cell in cells), default=0)
