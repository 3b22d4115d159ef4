"""A study: rides of all combinations of its axes on equal seeds, and a report of them.

A study of your own is a file with a function ``create``; ``cohelm bench FILE.py`` rides it and has
an option for each of its arguments, see ``docs/results.md``. Those of cohelm lie in ``rides``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from cohelm.benchmarks.bench import BenchReport, Result, Task, key_of
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.scenarios.scenario import Scenario

VARY = "--vary"
Columns = tuple[tuple[str, str], ...]
"""(column of the rows, value) of each."""


@dataclass(frozen=True)
class Variant:
    """One value of an axis: its columns in the rows, and what it sets in the scenario."""

    columns: Columns = ()
    settings: tuple[str, ...] = ()
    """``dotted.key=value``, for which it is called what it is called."""
    defaults: tuple[str, ...] = ()
    """Settings that those of all variants and of all rides override."""
    scenario: str = ""
    """Name or file; empty: that of another axis."""
    drawn: Callable[[int], tuple[str, ...]] | None = None
    """More settings, by the seed."""

    @property
    def label(self) -> str:
        """Values of its columns."""
        return ", ".join(word for _, word in self.columns)

    def at(self, seed: int) -> Variant:
        """Return the variant with all its settings for a seed."""
        if self.drawn is None:
            return self
        return replace(self, settings=(*self.settings, *self.drawn(seed)), drawn=None)


Axis = tuple[Variant, ...]
"""What is compared, or the cases in which it is."""


def common(settings: Sequence[str]) -> Axis:
    """Axis of one variant without a column: settings of all rides."""
    return (Variant(settings=tuple(settings)),)


def axis(column: str, values: Mapping[str, Sequence[str]]) -> Axis:
    """Axis of one column, value → its settings."""
    return tuple(Variant(((column, name),), tuple(each)) for name, each in values.items())


def varied(given: Sequence[str]) -> Axis:
    """Axis of all combinations of the values that ``key=a,b,c`` lists for each key.

    Values are YAML, so a list is one value: ``people.speed=[0.4,0.6],[1.0,1.2]``. Without keys
    there is one variant without columns.

    Raises:
        ConfigError: if one is not ``key=value,value``, or a value or a key is repeated.
    """
    keys: dict[str, tuple[str, ...]] = {}
    for text in given:
        key, equals, listed = text.partition("=")
        key = key.strip()
        if not equals or not key or not listed.strip():
            raise ConfigError("write key=a,b,c, as in people.count=1,3,5", key=f"{VARY} {text}")
        if key in keys:
            raise ConfigError("is given twice; list all its values once", key=f"{VARY} {key}")
        keys[key] = _values(key, listed)
    return tuple(
        Variant(
            columns=tuple(zip(keys, values, strict=True)),
            settings=tuple(f"{key}={each}" for key, each in zip(keys, values, strict=True)),
        )
        for values in itertools.product(*keys.values())
    )


def _values(key: str, listed: str) -> tuple[str, ...]:
    """Values of a list, each as YAML."""
    try:
        values = yaml.safe_load(f"[{listed}]")
    except yaml.YAMLError:
        raise ConfigError(f"{listed!r} is not a list of values", key=f"{VARY} {key}") from None
    texts = [_as_line(each) for each in values]
    if len(set(texts)) < len(texts):
        raise ConfigError(f"{listed!r} has a value twice", key=f"{VARY} {key}")
    return tuple(texts)


def _as_line(content: Any) -> str:
    """YAML of a value on one line, without the end marker that follows a bare word."""
    return yaml.safe_dump(content, default_flow_style=True, width=math.inf).splitlines()[0]


def ride_of(variants: Iterable[Variant], seed: int) -> RideTask:
    """Ride with one variant of each axis; settings of later axes override earlier ones."""
    chosen = [each.at(seed) for each in variants]
    return RideTask(
        columns=tuple(itertools.chain.from_iterable(each.columns for each in chosen)),
        scenario="".join(each.scenario for each in chosen),
        settings=tuple(
            itertools.chain(*(v.defaults for v in chosen), *(v.settings for v in chosen))
        ),
        seed=seed,
    )


def scenario_of(variants: Iterable[Variant], seed: int, more: tuple[str, ...] = ()) -> Scenario:
    """Load the scenario of one ride.

    Raises:
        ScenarioError, PluginError: see :func:`~cohelm.scenarios.scenario.load_scenario`.
    """
    return ride_of(variants, seed).load(more)


@dataclass(frozen=True)
class Grid:
    """All combinations of the variants of some axes, seed by seed."""

    axes: tuple[Axis, ...]
    """Columns appear in their order; one axis names scenarios."""
    compared: int = 1
    """Number of axes, from the last, whose rides are one task: an interrupt leaves none or all."""
    keep: Callable[[Mapping[str, str], int, range], bool] | None = None
    """False for a ride, by its columns, seed and all seeds, that is left out."""

    def __post_init__(self) -> None:
        """Check the axes.

        Raises:
            ConfigError: if one is empty, or not exactly one names scenarios.
        """
        if not all(self.axes) or not 1 <= self.compared <= len(self.axes):
            raise ConfigError("a study compares one to all of its axes, and none is empty")
        named = [all(each.scenario for each in axis) for axis in self.axes if _names(axis)]
        if named != [True]:
            raise ConfigError("one axis of a study names a scenario with each variant, others none")

    def check(self) -> None:
        """Check that no setting of all rides changes what a variant is called for, or is ignored.

        Raises:
            ConfigError: naming the setting.
        """
        own = [each.at(0) for axis in self.axes for each in axis if each.columns]
        shared = [s for axis in self.axes for c in axis if not c.columns for s in c.at(0).settings]
        for setting, variant in itertools.product(shared, own):
            for other in variant.settings:
                a, b = f"{key_of(setting)}.", f"{key_of(other)}."
                if setting != other and (a.startswith(b) or b.startswith(a)):
                    raise ConfigError(
                        f"is set by {variant.label!r} ({other}) and cannot be set for all rides",
                        key=key_of(setting),
                    )

    def __call__(self, seeds: range) -> list[tuple[RideTask, ...]]:
        """List the tasks."""
        cases, contenders = self.axes[: -self.compared], self.axes[-self.compared :]
        return [
            task
            for seed in seeds
            for case in itertools.product(*cases)
            if (task := tuple(self._rides(case, contenders, seed, seeds)))
        ]

    def _rides(
        self, case: Sequence[Variant], contenders: Sequence[Axis], seed: int, seeds: range
    ) -> Iterable[RideTask]:
        drawn = [each.at(seed) for each in case]
        for compared in itertools.product(*contenders):
            ride = ride_of((*drawn, *compared), seed)
            if self.keep is None or self.keep(dict(ride.columns), seed, seeds):
                yield ride


def _names(axis: Axis) -> bool:
    return any(each.scenario for each in axis)


def ride_all(task: Sequence[RideTask], *, empty_floor: bool = True) -> list[Result]:
    """Ride a task; with ``empty_floor`` also without people, for ``time_empty_floor``."""
    return [ride_row(each, empty_floor=empty_floor) for each in task]


@dataclass(frozen=True)
class Study:
    """A benchmark of rides; see :class:`~cohelm.benchmarks.bench.Bench`."""

    TITLE: str
    plan: Callable[[range], Sequence[Task]]
    """Seeds → tasks, in the order of the table: a :class:`Grid`, or a function."""
    report_on: Callable[[Sequence[Result], Path], BenchReport]
    """Results and folder → report, see :func:`~cohelm.benchmarks.rides.report.ride_report`."""
    ride: Callable[[Sequence[RideTask]], Sequence[Result]] = ride_all
    """How the rides of a task are made."""
    SEEDS: int = 20
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """List the tasks."""
        return self.plan(seeds)

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Make the rides of a task."""
        return self.ride(task)

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Summarise the rides."""
        return self.report_on(results, folder)

    def checked(self, part: str = "local_planner") -> Study:
        """Return the study after a check, without riding: settings, and that rides can be built.

        Args:
            part: compared key of :data:`~cohelm.scenarios.scenario.PARTS`.

        Raises:
            ScenarioError, PluginError, ConfigError: if something does not exist or does not fit.
        """
        if isinstance(self.plan, Grid):
            self.plan.check()
        check_rides(self.tasks(range(1)), part)
        return self
