"""The static experiment of Xu et al., Fig. 13: narrow corridors, ridden by hand, alone and shared.

The paper's people rode; here simulated riders do, each with the same seeds in every mode. What it
calls shared control is ``shared``; ``assisted`` is the rider alone behind the safety gate. Nobody
was asked for their satisfaction: effort and agreement are stand-ins, and named so.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

from cohelm.evaluation.benches.bench import Report, Result, Task, parted
from cohelm.evaluation.benches.steering import SteeringBench, chosen

TITLE = "The paper's corridors by hand, assisted, shared and alone (Xu et al., Fig. 13)"
SEEDS = 5
WORKERS = None
CORRIDORS = ("corridor-1", "corridor-2", "corridor-3", "corridor-4")
"""Each has something on its centre line or nearly, and a turn in at most 1.3 m."""


def on(
    riders: str | None = None,
    modes: str | None = None,
    scenes: str | None = None,
    settings: Sequence[str] = (),
    *,
    true_people: bool = False,
) -> SteeringBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError: if something does not exist, before anything is
            ridden.
    """
    where = parted(scenes, "--scenes") or CORRIDORS
    names, ways, found = chosen(where, riders, modes, settings, true_people=true_people)
    return SteeringBench(names, ways, found, "paper", TITLE, SEEDS, WORKERS)


@cache
def _usual() -> SteeringBench:
    return on()


def tasks(seeds: range) -> Sequence[Task]:
    """See :meth:`SteeringBench.tasks`."""
    return _usual().tasks(seeds)


def work(task: Task, folder: Path) -> Sequence[Result]:
    """See :meth:`SteeringBench.work`."""
    return _usual().work(task, folder)


def report(results: Sequence[Result], folder: Path) -> Report:
    """See :meth:`SteeringBench.report`."""
    return _usual().report(results, folder)
