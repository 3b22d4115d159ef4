"""CrowdNav's circle crossing with an invisible robot: success, time and danger of planners.

The recorded cases are those on which the references were measured. Own cases have other seeds, and
may have other layouts and more people; parameters are tuned on them only.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Literal

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name
from cohelm.benchmarks.claims import OURS
from cohelm.benchmarks.external.crowdnav_report import crowdnav_report
from cohelm.config import override, read_yaml, validate
from cohelm.errors import ConfigError
from cohelm.evaluation.external.crowdnav import (
    LAYOUTS,
    MODELS,
    Driver,
    Model,
    own_case,
    recorded,
    run,
)
from cohelm.evaluation.external.crowdnav_drivers import (
    BEST_ARC,
    DriverSetup,
    PlannerDriver,
    orca,
    straight,
)
from cohelm.stopwatch import Timing

TITLE = "CrowdNav, invisible robot"
REFERENCE_DRIVERS = ("straight", "orca")
"""Drivers that check the port against known figures; they are no planners."""
RECORDING = "7e834326f6e39dfb2ec187a1868615686b2ea22877bec41484a4f904e1b4d915"
"""SHA-256 of the recorded states on which the references were measured."""
Source = Literal["recorded", "circle", "square"]


@dataclass(frozen=True)
class CrowdNavBench:
    """The benchmark of one planner; a seed is the number of a case."""

    planner: str = OURS
    models: tuple[Model, ...] = MODELS
    source: Source = "recorded"
    people: int = 5
    """Number of people in own cases."""
    replay: Path | None = None
    """Another recording; None: the one in COHELM_DATA."""
    cautions: tuple[float, ...] = (0.0,)
    settings: tuple[str, ...] = ()
    SEEDS: int = 500
    WORKERS: int | None = None

    @property
    def TITLE(self) -> str:
        """Title with planner and cases."""
        where = "the recorded cases"
        if self.source != "recorded":
            where = f"own cases: {self.people} people cross a {self.source}"
        return f"{TITLE}: {self.planner} in {where}"

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per case, kind of robot and caution."""
        cases = seeds
        if self.source == "recorded":
            count = len(recorded(self.replay))
            if seeds.stop > count:
                raise ConfigError(f"has {count} cases, not {seeds.stop}", key="--seeds")
        self._driver(0.0, self.models[0])  # wrong settings fail here, not in a case
        return [(c, m, case) for c in self.cautions for m in self.models for case in cases]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Drive one case."""
        caution, model, case = task
        driver = self._driver(caution, model)
        outcome = run(self._people(case), driver, model)
        times = driver.times if isinstance(driver, PlannerDriver) else []
        # The first command includes compilation.
        timing = Timing.of(times[1:] or times) if times else None
        row = {
            "case": case,
            "kinematics": model,
            "caution": caution,
            "outcome": outcome.end,
            "time": outcome.time,
            "path": outcome.path,
            "steps": outcome.steps,
            "danger": outcome.danger,
            "least_gap": outcome.least_gap,
            "command_ms": timing.median if timing else np.nan,
            "command_p99_ms": timing.p99 if timing else np.nan,
        }
        return [Result(row=row)]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table, references where they apply, curve over caution, verdicts."""
        references = self.has_references()
        return crowdnav_report(
            [each.row for each in results],
            self.planner,
            folder,
            references=references,
            judged=references and self.planner == OURS and not self.settings,
        )

    def has_references(self) -> bool:
        """Check that the cases are the recording on which the references were measured."""
        if self.source != "recorded":
            return False
        states = np.ascontiguousarray(_recorded(self.replay), dtype="<f8")
        return hashlib.sha256(states.tobytes()).hexdigest() == RECORDING

    def _people(self, case: int) -> Floats:
        if self.source == "recorded":
            return np.asarray(_recorded(self.replay)[case])
        return own_case(self.source, self.people, case)

    def _driver(self, caution: float, model: Model) -> Driver:
        if self.planner == "straight":
            return straight(model)
        if self.planner == "orca":
            return orca(caution)
        return PlannerDriver(self._setup(caution), model)

    def _setup(self, caution: float) -> DriverSetup:
        stored = read_yaml(Path(str(files("cohelm.evaluation.external") / "crowdnav.yaml")))
        given = override(stored.get(self.planner, {}), self.settings)
        setup = validate(DriverSetup, {**given, "caution": caution})
        return setup.model_copy(update={"planner": {**setup.planner, "use": self.planner}})


def create(  # each parameter is an option of the command
    *,
    planner: str = OURS,
    kinematics: str | None = None,
    replay: Path | None = None,
    layout: str | None = None,
    people: int = 5,
    caution: Sequence[float] = (0.0,),
    settings: Sequence[str] = (),
) -> CrowdNavBench:
    """Create the benchmark from its options.

    Args:
        planner: local planner; ``best_arc``: sampling alone; ``straight``, ``orca``: references.
        kinematics: of the robot; None: both, one after the other.
        replay: another recording.
        layout: own cases: ``circle`` or ``square``.
        people: number of people in own cases.
        caution: added to every person's radius as the planner receives it, m; one row each.
        settings: ``dotted.key=value`` of the driver, ``planner.…`` or ``predictor.…``.

    Raises:
        ConfigError: if a name or a setting does not exist.
    """
    known = (*plugins.names("local_planners"), BEST_ARC, *REFERENCE_DRIVERS)
    known_name(planner, known, "planner", "--planner")
    models = MODELS
    if kinematics is not None:
        models = (known_name(kinematics, MODELS, "kind of robot", "--kinematics"),)
    if planner == "orca":
        if kinematics not in {None, "holonomic"}:
            raise ConfigError("orca moves a holonomic robot only", key="--kinematics")
        models = ("holonomic",)
    if layout is not None and replay is not None:
        raise ConfigError("either a recording or own cases", key="--layout")
    for each in caution:
        validate(DriverSetup, {"caution": each})
    source: Source = "recorded"
    if layout is not None:
        source = known_name(layout, LAYOUTS, "layout", "--layout")
    return CrowdNavBench(
        planner=planner,
        models=models,
        source=source,
        people=people,
        replay=replay,
        cautions=tuple(caution),
        settings=tuple(settings),
    )


@functools.lru_cache(maxsize=1)
def _recorded(replay: Path | None) -> Floats:
    return recorded(replay)
