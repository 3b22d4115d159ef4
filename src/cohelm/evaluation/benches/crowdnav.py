"""CrowdNav's circle crossing with a robot that nobody sees: success, time and danger of planners.

The recorded cases are those on which the references were measured. Cases of our own have other
seeds, and may have other layouts and more people; whatever is tuned is tuned on them.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.config import nearest, override, read_yaml, validate
from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Report, Result, Task
from cohelm.evaluation.benches.crowdnav_report import make_report
from cohelm.evaluation.crowdnav import MODELS, Driver, Model, recorded, run
from cohelm.evaluation.crowdnav_cases import LAYOUTS, own_case
from cohelm.evaluation.crowdnav_drivers import BEST_ARC, PlannerDriver, Setup, orca, straight

TITLE = "CrowdNav, invisible robot"
SEEDS = 500
WORKERS = None

PLANNER = "ss_mpc_dcbf"
REFERENCES = ("straight", "orca")
"""Run through the same harness to check it; they are no planners."""
Source = Literal["recorded", "circle", "square"]


@dataclass(frozen=True)
class CrowdNav:
    """The benchmark of one planner; a seed is the number of a case."""

    planner: str = PLANNER
    models: tuple[Model, ...] = MODELS
    source: Source = "recorded"
    people: int = 5
    """Of cases of our own."""
    replay: Path | None = None
    """Another recording; None: the one in COHELM_DATA."""
    cautions: tuple[float, ...] = (0.0,)
    settings: tuple[str, ...] = ()
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    @property
    def TITLE(self) -> str:
        """With what was asked for."""
        where = "the recorded cases"
        if self.source != "recorded":
            where = f"our own cases: {self.people} people cross a {self.source}"
        return f"{TITLE}: {self.planner} in {where}"

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each case, kind of robot and caution."""
        cases = seeds
        if self.source == "recorded":
            there = len(recorded(self.replay))  # says at once where it is not there
            if seeds.stop > there:
                raise ConfigError(f"has {there} cases, not {seeds.stop}", key="--seeds")
        self._driver(0.0, self.models[0])  # and what of the settings is wrong
        return [(c, m, case) for c in self.cautions for m in self.models for case in cases]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """One case."""
        caution, model, case = task
        driver = self._driver(caution, model)
        outcome = run(self._people(case), driver, model)
        times = driver.times if isinstance(driver, PlannerDriver) else []
        times = times[1:] or times  # the first may have been compiled for
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
            "command_ms": 1e3 * float(np.median(times)) if times else np.nan,
            "command_p99_ms": 1e3 * float(np.percentile(times, 99)) if times else np.nan,
        }
        return [Result(row=row)]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """The table beside the references, the curve over caution, verdicts."""
        usual = self.planner == PLANNER and not self.settings
        whole = self.source == "recorded" and self.replay is None and usual
        return make_report([each.row for each in results], self.planner, folder, judged=whole)

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

    def _setup(self, caution: float) -> Setup:
        stored = read_yaml(Path(str(files("cohelm.evaluation") / "crowdnav.yaml")))
        given = override(stored.get(self.planner, {}), self.settings)
        setup = validate(Setup, {**given, "caution": caution})
        return setup.model_copy(update={"planner": {**setup.planner, "use": self.planner}})


def on(  # each is an option
    *,
    planner: str = PLANNER,
    kinematics: str | None = None,
    replay: Path | None = None,
    layout: str | None = None,
    people: int = 5,
    caution: Sequence[float] = (0.0,),
    settings: Sequence[str] = (),
) -> CrowdNav:
    """The benchmark of another planner, in other cases, or with other settings.

    Args:
        planner: a local planner; ``best_arc``: sampling alone; ``straight``, ``orca``: references.
        kinematics: of the robot; None: both, one after the other.
        replay: another recording.
        layout: cases of our own: ``circle`` or ``square``.
        people: in those.
        caution: added to everybody's radius as the planner is told it, m; a row for each.
        settings: ``dotted.key=value`` of what drives, ``planner.…`` or ``predictor.…``.

    Raises:
        ConfigError: if something is asked for that does not exist.
    """
    known = (*plugins.names("local_planners"), BEST_ARC, *REFERENCES)
    _require(planner, known, "planner", "--planner")
    models = MODELS if kinematics is None else (_require(kinematics, MODELS, "kind of robot",
                                                         "--kinematics"),)  # fmt: skip
    if planner == "orca":
        if kinematics not in {None, "holonomic"}:
            raise ConfigError("orca moves a holonomic robot only", key="--kinematics")
        models = ("holonomic",)
    if layout is not None and replay is not None:
        raise ConfigError("either a recording or cases of our own", key="--layout")
    for each in caution:
        validate(Setup, {"caution": each})
    source: Source = (
        "recorded" if layout is None else _require(layout, LAYOUTS, "layout", "--layout")
    )
    return CrowdNav(
        planner=planner,
        models=models,
        source=source,
        people=people,
        replay=replay,
        cautions=tuple(caution),
        settings=tuple(settings),
    )


def _require(name: Any, known: Sequence[str], what: str, key: str) -> Any:
    if name not in known:
        raise ConfigError(f"no {what} is called {name!r}{nearest(name, known)}", key=key)
    return name


@functools.lru_cache(maxsize=1)
def _recorded(replay: Path | None) -> Floats:
    return recorded(replay)
