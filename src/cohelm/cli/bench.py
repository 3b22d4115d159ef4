"""``cohelm bench``: run a benchmark, and write rows, tables and pictures to a folder."""

from __future__ import annotations

import os
import pickle
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from rich.text import Text

from cohelm.benchmarks.bench import Bench, BenchReport, Task
from cohelm.benchmarks.study import Grid, Study
from cohelm.cli.progress import SweepProgress
from cohelm.cli.report import ERRORS, OUTPUT, as_json, fitted_table, versions, write_json
from cohelm.cli.requests import BenchRequest
from cohelm.cli.streams import log_to_stderr
from cohelm.errors import ConfigError
from cohelm.evaluation.code_version import code, digest
from cohelm.evaluation.sweeps.identity import canonical_text, check_plain
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.store import SweepHeader, SweepStore, check_new
from cohelm.evaluation.sweeps.sweep import SweepResult, executor_for, sweep

FAILED, INTERRUPTED = 1, 130


def bench(name: str, module: str, request: BenchRequest) -> int:
    """Run a benchmark; returns 0, 1 where tasks failed, 130 where it was interrupted.

    Raises:
        ConfigError: if the folder cannot be written to, has results and neither --resume nor
            --overwrite is set, or belongs to another sweep.
        WorkersFailed: if no workers with the right versions are found.
    """
    done, report = run_bench(name, module, request)
    if report is not None and request.json:
        write_json(_summary(name, done, report))
    return INTERRUPTED if not done.is_complete else FAILED if done.errors or report is None else 0


def run_bench(
    name: str, module: str, request: BenchRequest
) -> tuple[SweepResult, BenchReport | None]:
    """Run a benchmark, write its results and, without --json, print them; raises as :func:`bench`.

    Returns:
        the finished tasks, and the report; None where there are too few results for one.
    """
    chosen, tasks, workers = _planned(module, request)
    folder = _folder(request.out or Path("benches") / name, request)
    options = {option: canonical_text(value) for option, value in request.options.items()}
    header = SweepHeader(bench=name, options=options, code={**code(), **own_code(module)})
    with executor_for(request.cluster, workers) as executor:
        begun = SweepStore(folder, header, resume=request.resume, overwrite=request.overwrite)
        with begun as store, SweepProgress(name) as bar:
            done = sweep(chosen, tasks, folder, executor=executor, store=store, watch=bar)
    notes = (*_faults(done), *_changed(store))
    report = _report(chosen, done, folder)
    if report is None:
        for note in notes:
            ERRORS.print(note, markup=False, soft_wrap=True)
        return done, None
    report = replace(report, notes=(*report.notes, *notes))
    text = as_json(_summary(name, done, report), indent=2)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8")
    if not request.json:
        _print(chosen.TITLE, report, folder, done)
    return done, report


def _summary(name: str, done: SweepResult, report: BenchReport) -> Mapping[str, Any]:
    return {
        **report.summary,
        "bench": name,
        "complete": done.is_complete,
        "tasks": {"done": done.done, "total": done.total},
        "failures": [{"task": i, **asdict(fault)} for i, fault in done.errors.items()],
        "rows": [result.row for result in done.results],
        "versions": versions(),
    }


def _planned(module: str, request: BenchRequest) -> tuple[Bench, Sequence[Task], int]:
    """The configured benchmark, its tasks, and the number of processes."""
    chosen = create_of(module)(**request.options)
    if not hasattr(chosen, "tasks"):
        raise ConfigError(f"create of {module!r} returns {chosen!r}, which is no study")
    seeds = chosen.SEEDS if request.seeds is None else request.seeds
    tasks = chosen.tasks(range(request.first, request.first + seeds))
    check_plain(tasks)
    _check_apart(tasks)
    if isinstance(chosen, Study) and isinstance(chosen.plan, Grid):
        chosen.plan.check()
    workers = request.workers or chosen.WORKERS or os.cpu_count() or 1
    if workers > 1 or request.cluster:
        _check_sendable(chosen, module)
    return chosen, tasks, workers


def create_of(module: str) -> Callable[..., Bench]:
    """Function that creates a benchmark: ``module`` or ``module:function``.

    Raises:
        ConfigError: if a file of a study cannot be imported, or has no such function.
    """
    name, _, function = module.partition(":")
    try:
        found: Callable[..., Bench] = getattr(import_module(name), function or "create")
    except Exception as cause:
        if name.startswith("cohelm."):
            raise
        raise ConfigError(f"cannot be used as a study: {cause}", file=Path(f"{name}.py")) from cause
    return found


def own_code(module: str) -> Mapping[str, str]:
    """Digest of the file of a study of one's own, by its name; empty for those of cohelm."""
    file = getattr(import_module(module.partition(":")[0]), "__file__", None)
    if module.startswith("cohelm.") or file is None:
        return {}
    return {Path(file).name: digest(Path(file).read_bytes())}


def _check_sendable(chosen: Bench, module: str) -> None:
    """Check that worker processes can get a study.

    Raises:
        ConfigError: if not, as with a lambda.
    """
    try:
        pickle.dumps(chosen.work)
    except (pickle.PicklingError, AttributeError, TypeError) as cause:
        raise ConfigError(
            f"{module} cannot be sent to worker processes ({cause}): use functions of the file "
            "instead of lambdas, or --workers 1"
        ) from None


def _check_apart(tasks: Sequence[Task]) -> None:
    """Refuse two different scenario files of one name: tables would mix them.

    Raises:
        ConfigError: if two different rides have the same columns and seed.
    """
    known: dict[tuple[object, int], RideTask] = {}
    for ride in (each for task in tasks for each in task if isinstance(each, RideTask)):
        other = known.setdefault((ride.columns, ride.seed), ride)
        if other.scenario != ride.scenario or other.settings != ride.settings:
            name = ", ".join(word for _, word in ride.columns)
            raise ConfigError(
                f"two different rides are called {name!r}, seed {ride.seed}: rename one file, or "
                "give one variant another column"
            )


def _folder(folder: Path, request: BenchRequest) -> Path:
    """Make the folder and check that it can be written to, before the work begins."""
    if request.resume and request.overwrite:
        raise ConfigError("cannot be combined with --overwrite", key="--resume")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as cause:
        raise ConfigError(
            f"{folder} is not a folder that can be written to ({cause.strerror})", key="--out"
        ) from None
    if not (request.resume or request.overwrite):
        check_new(folder)  # checked again under the lock
    return folder


def _report(chosen: Bench, done: SweepResult, folder: Path) -> BenchReport | None:
    """Report of the results; None, with a message, where there are too few of them."""
    if not done.results:
        return None
    try:
        with log_to_stderr():
            return chosen.report(done.results, folder)
    except Exception as failure:  # a report of few rides may fail in any way
        if done.is_complete and not done.errors:
            raise
        text = f"too few results for a report ({type(failure).__name__}: {failure})"
        ERRORS.print(f"{text}; they are kept in {folder}, continue with --resume", markup=False)
        return None


def _faults(done: SweepResult) -> list[str]:
    """One line for each kind of failure."""
    kinds: dict[str, list[int]] = {}
    for index, fault in done.errors.items():
        kinds.setdefault(fault.error, []).append(index)
    return [
        f"FAILED: {len(each)} of {done.total} tasks, first task {each[0]}: {error}"
        for error, each in kinds.items()
    ]


def _changed(store: SweepStore) -> list[str]:
    if not store.changed:
        return []
    return [f"some rides are older than the current code ({store.changed})"]


def _print(title: str, report: BenchReport, folder: Path, done: SweepResult) -> None:
    OUTPUT.print(Text(title, style="bold"))
    for sheet in report.sheets:
        if sheet.rows:
            OUTPUT.print(fitted_table(sheet.title, sheet.columns, sheet.rows))
    for note in report.notes:
        OUTPUT.print(note, markup=False)
    if not done.is_complete:
        text = f"interrupted after {done.done} of {done.total} tasks; continue with --resume"
        OUTPUT.print(text, style="yellow")
    names = ["rows.csv", "summary.json", *(file.name for file in report.files)]
    OUTPUT.print(f"written to {folder}: {', '.join(names)}", markup=False, soft_wrap=True)
