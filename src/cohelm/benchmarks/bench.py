"""Contract of a benchmark: tasks from seeds, rows from each task, a report from the rows.

A benchmark's module has a function ``create(**options)`` that returns a :class:`Bench`; one line in
``cohelm.cli.bench_commands`` makes it a command, with an option for each argument of ``create``; a
file of one's own needs no entry. ``cohelm.evaluation.sweeps`` runs the tasks.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.evaluation.report.write import BenchReport, Sheet
from cohelm.evaluation.sweeps.sweep import run_tasks
from cohelm.evaluation.sweeps.tasks import Result, SweepState, Task
from cohelm.recordings.outside_data import outside_data

__all__ = [
    "LOCAL_PLANNERS",
    "Bench",
    "BenchReport",
    "Result",
    "Sheet",
    "SweepState",
    "Task",
    "chosen_names",
    "known_name",
    "missing_data",
    "run_tasks",
    "split_names",
    "unset",
]

LOCAL_PLANNERS: Mapping[str, str] = MappingProxyType({"local_planner": "--planners"})
"""Key that a benchmark of local planners compares, for :func:`unset`."""


class Bench(Protocol):
    """A benchmark; the options of its ``create`` and its tasks identify the sweep."""

    TITLE: str
    SEEDS: int
    """Number of seeds if the user gives none."""
    WORKERS: int | None
    """Number of processes; None: one per processor. A benchmark that measures time takes one."""

    def tasks(self, seeds: range) -> Sequence[Task]:
        """List the tasks in the order of the table."""
        ...

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Do one task in a process of its own; equal tasks give equal rows, times excepted."""
        ...

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Summarise the available results; writes pictures to the folder."""
        ...


def split_names(names: str | None, option: str) -> tuple[str, ...]:
    """Split a comma-separated list of names; duplicates are dropped, None gives ().

    Raises:
        ConfigError: if the option is given but empty; an empty list does not mean all.
    """
    found = tuple(dict.fromkeys(filter(None, map(str.strip, (names or "").split(",")))))
    if names is not None and not found:
        raise ConfigError(f"names nothing ({names!r}); omit it for the default", key=option)
    return found


def chosen_names(
    names: str | None,
    option: str,
    default: Iterable[str],
    *,
    kind: str = "",
    known: Collection[str] | None = None,
) -> tuple[str, ...]:
    """Names of an option, comma-separated, or its default.

    Raises:
        ConfigError: if it names nothing, or something that is not ``known``.
    """
    found = split_names(names, option)
    if known is not None:
        for name in found:
            known_name(name, tuple(known), kind, option)
    return found or tuple(default)


def known_name(name: Any, known: Sequence[Any], kind: str, option: str) -> Any:
    """Return ``name`` if it is known.

    Raises:
        ConfigError: with the nearest known name otherwise.
    """
    if name not in known:
        raise ConfigError(f"no {kind} is called {name!r}{nearest(name, known)}", key=option)
    return name


def unset(settings: Iterable[str], compared: Mapping[str, str]) -> None:
    """Check that no setting fixes what the benchmark compares.

    Args:
        settings: ``dotted.key=value`` of a scenario.
        compared: key of the scenario → the option that sets it. The seed is always compared.

    Raises:
        ConfigError: naming the option that sets the key.
    """
    for setting in settings:
        for key, option in {"seed": "--seeds and --first", **compared}.items():
            # parameters of what is compared, as ``local_planner.iterations``, may be set
            if f"{key}.use.".startswith(f"{key_of(setting)}."):
                text = f"is set by {option} and cannot be set for all rides"
                raise ConfigError(text, key=key_of(setting))


def key_of(setting: str) -> str:
    """Key of ``dotted.key=value``."""
    return setting.partition("=")[0].strip()


def missing_data(*names: str) -> str:
    """Reason why a file of the outside data cannot be read."""
    if outside_data() is None:
        return "COHELM_DATA is not set; it names the folder of the outside data (cohelm data)"
    return f"{'/'.join(names)} is not in COHELM_DATA"
