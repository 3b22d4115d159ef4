"""What a benchmark is: tasks from seeds, rows from each task, a report from the rows.

Its module has a function ``on(**options)`` that makes a :class:`Bench` of what is asked for, the
usual one where nothing is; one line in ``cohelm.cli.benches.BENCHES`` makes it a command. How its
tasks are done and kept is the matter of ``cohelm.evaluation.sweeps``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.sweep import run_tasks, write_rows
from cohelm.evaluation.sweeps.tasks import Fault, Progress, Result, Task

__all__ = [
    "LOCAL_PLANNERS",
    "Bench",
    "Fault",
    "Progress",
    "Report",
    "Result",
    "Sheet",
    "Task",
    "check_free",
    "parted",
    "run_tasks",
    "write_rows",
]


@dataclass(frozen=True)
class Sheet:
    """A table for people."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Report:
    """What the results say."""

    sheets: tuple[Sheet, ...]
    notes: tuple[str, ...]
    """Sentences: what was met, what was missed, what could not be run."""
    summary: Mapping[str, Any]
    """The same for programs."""
    files: tuple[Path, ...] = ()
    """What was written beyond the rows."""


def parted(names: str | None, key: str) -> tuple[str, ...]:
    """Names that an option lists with commas, each once; none where it is not given.

    Args:
        names: what was written; None: nothing was.
        key: the option.

    Raises:
        ConfigError: if it is given and names nothing: it does not mean everything then.
    """
    found = tuple(dict.fromkeys(filter(None, map(str.strip, (names or "").split(",")))))
    if names is not None and not found:
        raise ConfigError(f"names nothing ({names!r}); leave it out for the usual ones", key=key)
    return found


LOCAL_PLANNERS: Mapping[str, str] = MappingProxyType({"local_planner": "--planners"})
"""What a benchmark of local planners compares, see :func:`check_free`."""


def check_free(settings: Iterable[str], compared: Mapping[str, str]) -> None:
    """Whether settings leave alone what is compared: every name in the tables would mean the same.

    Args:
        settings: ``dotted.key=value`` of a scenario.
        compared: key of the scenario → the option that says it; the seed is one anyway.

    Raises:
        ConfigError: if a setting says it.
    """
    options = {"seed": "--seeds and --first", **compared}
    for setting in settings:
        key = setting.partition("=")[0].strip()
        option = options.get(key.removesuffix(".use"))
        if option is not None:
            raise ConfigError(f"is said by {option} here, and cannot be set for all rides", key=key)


class Bench(Protocol):
    """A benchmark: a frozen dataclass, whose fields are what its options say.

    They tell one sweep from another.
    """

    TITLE: str
    SEEDS: int
    """How many seeds where no number is asked for."""
    WORKERS: int | None
    """How many processes; None: as many as there are processors. Who measures time takes one."""

    def tasks(self, seeds: range) -> Sequence[Task]:
        """What is to be done, in the order of the table."""
        ...

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Do one task, in a process of its own; the same task gives the same rows, timing apart."""
        ...

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """What the results there are say; writes pictures to the folder."""
        ...
