"""Ten riders in four modes and five scenes: who can ride with this chair, and at what cost.

Every rider rides the same seeds by hand, assisted, shared and alone. In ``distracted`` the moment
of the turn is swept over the seeds, see ``rides_scenes``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

from cohelm.evaluation.benches.bench import Report, Result, Task, parted
from cohelm.evaluation.benches.steering import SteeringBench, chosen

TITLE = "Riders of all kinds by hand, assisted, shared and alone"
SEEDS = 10
WORKERS = None
SCENES = ("corridor-1", "corridor-4", "crossing", "distracted", "talking")


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
    where = parted(scenes, "--scenes") or SCENES
    names, ways, found = chosen(where, riders, modes, settings, true_people=true_people)
    return SteeringBench(names, ways, found, "limits", TITLE, SEEDS, WORKERS)


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
