"""CrowdNav's circle crossing with an invisible robot: success, time and danger of planners.

The recorded cases are those on which the references were measured. Own cases have other seeds, and
may have other layouts and more people; parameters are tuned on them only.
The report puts the results of others in the same cases beside them.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import typer
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet, Task, known_name
from cohelm.benchmarks.claims import (
    OURS,
    Bound,
    Verdict,
    bounded,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.options import repeatable
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
from cohelm.recordings.outside_data import outside_file
from cohelm.stopwatch import Timing

Row = Mapping[str, Any]


class CrowdNavLine(NamedTuple):
    """One line of the table; NaN: not known."""

    name: str
    kinematics: str
    success: float
    collision: float
    time: float
    """Mean over the successes, s; so are the next two."""
    path: float = np.nan
    danger: float = np.nan
    """Share of steps with a distance below 0.2 m."""


REFERENCES = (
    CrowdNavLine("clairvoyant (knows the recorded future)", "holonomic", 1.0, 0.0, 8.71),
    CrowdNavLine("clairvoyant (knows the recorded future)", "unicycle", 1.0, 0.0, 8.48),
    CrowdNavLine("crude sampler, constant velocity", "holonomic", 0.934, 0.066, 11.29),
    CrowdNavLine("crude sampler, constant velocity", "unicycle", 0.528, 0.440, 10.70),
    CrowdNavLine("ORCA, radius + 0.20 m", "holonomic", 0.936, 0.050, 12.52, 9.58),
)
"""Measured on the 500 recorded cases; also in docs/crowdnav.md."""
RECORDED = "crowdnav_measured_summary.json"
"""File beside the recording: references measured by CrowdNav's own code."""
REQUIRED: Mapping[str, Mapping[str, Bound]] = {
    "holonomic": {"success": Bound(low=0.998), "time": Bound(high=10.5)},
    "unicycle": {"success": Bound(low=0.99), "time": Bound(high=11.2)},
}
REQUIRED_OF_BOTH: Mapping[str, Bound] = {
    "collision": Bound(high=0.005),
    "danger": Bound(high=0.01),
}
"""Requirements on our planner in the recorded cases."""
CASES = 500
"""Number of recorded cases."""
_COLUMNS = ("", "robot", "success", "collision", "time, s", "path, m", "danger of successes")


def crowdnav_report(
    rows: Sequence[Row], planner: str, folder: Path, *, references: bool, judged: bool
) -> BenchReport:
    """Tables, the curve over caution where there is one, and the verdicts.

    Args:
        rows: of all cases.
        planner: that drove.
        folder: for the picture.
        references: True where the cases are those of ``REFERENCES``.
        judged: True where the requirements apply to these cases and this planner.
    """
    cautions = sorted({float(row["caution"]) for row in rows})
    models = list(dict.fromkeys(str(row["kinematics"]) for row in rows))
    groups = {(c, m): _of(rows, c, m) for c in cautions for m in models}
    lines = {key: summed(each, planner, key[1]) for key, each in groups.items() if each}
    first = 0.0 if 0.0 in cautions else cautions[0]
    main = [line for (c, _), line in lines.items() if c == first]
    verdicts = list(_verdicts(main)) if judged and first == 0.0 else []
    notes = [_speed(groups[first, line.kinematics], line.kinematics) for line in main]
    fewest = min(len(groups[first, line.kinematics]) for line in main)
    if verdicts and fewest < CASES:
        notes.append(f"{fewest} of the {CASES} recorded cases: the verdicts are no findings")
    wider = f", people {first:+g} m wider" if first else ""
    sheets = [Sheet(f"successes and their cost{wider}", _COLUMNS, tuple(map(_cells, main)))]
    if references:
        others = tuple(map(_cells, _others()))
        sheets.append(Sheet("others in the recorded cases", _COLUMNS, others))
    files: tuple[Path, ...] = ()
    if len(cautions) > 1:
        curve = [
            (f"{c:g} m", *_cells(lines[c, m])[1:])
            for m in models
            for c in cautions
            if (c, m) in lines
        ]
        sheets.append(Sheet("wider people", ("added", *_COLUMNS[1:]), tuple(curve)))
        files = (_picture(lines, folder / "curve.png"),)
    if verdicts:
        sheets.append(verdict_sheet(verdicts))
    summary = {
        "lines": [{"caution": c, **line._asdict()} for (c, _), line in lines.items()],
        "verdicts": verdict_summary(verdicts),
    }
    return BenchReport(tuple(sheets), (*notes, *verdict_notes(verdicts)), summary, files)


def summed(rows: Sequence[Row], name: str, kinematics: str) -> CrowdNavLine:
    """Shares over all cases, means over the successes."""
    ends = [row["outcome"] for row in rows]
    won = [row for row in rows if row["outcome"] == "success"]
    steps = sum(row["steps"] for row in won)
    return CrowdNavLine(
        name=name,
        kinematics=kinematics,
        success=ends.count("success") / len(ends),
        collision=ends.count("collision") / len(ends),
        time=float(np.mean([row["time"] for row in won])) if won else np.nan,
        path=float(np.mean([row["path"] for row in won])) if won else np.nan,
        danger=sum(row["danger"] for row in won) / steps if steps else np.nan,
    )


def _of(rows: Sequence[Row], caution: float, model: str) -> list[Row]:
    return [row for row in rows if row["caution"] == caution and row["kinematics"] == model]


def _others() -> list[CrowdNavLine]:
    """References measured by CrowdNav's own code where the file exists, and the fixed ones."""
    file = outside_file("crowdnav", RECORDED)
    recorded = [] if file is None else json.loads(file.read_text(encoding="utf-8"))
    names = {"linear": "straight ahead", "orca": "ORCA"}
    found = [
        CrowdNavLine(
            names.get(each["policy"], each["policy"])
            + (f", radius + {each['safety']:.2f} m" if each["safety"] else ""),
            "holonomic",
            each["success"],
            each["collision"],
            each["nav_time"],
            each["path"],
            each["danger_freq"],
        )
        for each in recorded
        if not each["visible"] and each["rule"] == "circle_crossing" and each["humans"] == 5
    ]
    return [*found, *REFERENCES]


def _cells(line: CrowdNavLine) -> tuple[str, ...]:
    figures = (f"{each:.{digits}f}" if np.isfinite(each) else "" for each, digits in
               zip(line[2:], (3, 3, 2, 2, 4), strict=True))  # fmt: skip
    return (line.name, line.kinematics, *figures)


def _speed(rows: Sequence[Row], model: str) -> str:
    median = float(np.median([row["command_ms"] for row in rows]))
    worst = float(np.max([row["command_p99_ms"] for row in rows]))
    if not np.isfinite(median):
        return f"{model}: no planner"
    return f"{model}: a command takes {median:.1f} ms, p99 of the worst case {worst:.1f} ms"


def _verdicts(lines: Sequence[CrowdNavLine]) -> Iterator[Verdict]:
    for line in lines:
        for name, bound in {**REQUIRED[line.kinematics], **REQUIRED_OF_BOTH}.items():
            yield bounded(line.kinematics, name, float(getattr(line, name)), bound)


def _picture(lines: Mapping[tuple[float, str], CrowdNavLine], file: Path) -> Path:
    """Draw success over mean time, one point per caution."""
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for k, model in enumerate(dict.fromkeys(model for _, model in lines)):
        own = [(c, line) for (c, m), line in lines.items() if m == model]
        axes.plot([line.time for _, line in own], [line.success for _, line in own], "o-",
                  label=model)  # fmt: skip
        for c, line in own:
            axes.annotate(f"{c:+.2f} m", (line.time, line.success), fontsize=7,
                          textcoords="offset points", xytext=(4, 6 - 16 * k))  # fmt: skip
    axes.set_xlabel("mean time of the successes, s")
    axes.set_ylabel("success")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(file, dpi=110)
    return file


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
    planner: Annotated[
        str,
        typer.Option(metavar="NAME", help="Local planner, or best_arc, straight, orca."),
    ] = OURS,
    kinematics: Annotated[
        str | None, typer.Option(metavar="MODEL", help="unicycle or holonomic; default: both.")
    ] = None,
    replay: Annotated[
        Path | None,
        typer.Option(metavar="FILE.npz", help="Recorded people; default: those in COHELM_DATA."),
    ] = None,
    layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Own cases instead: circle or square."),
    ] = None,
    people: Annotated[int, typer.Option(min=1, max=20, help="Number of people in own cases.")] = 5,
    caution: Annotated[
        tuple[float, ...],
        repeatable("--caution", "M", "Added to every person's radius for the planner, m"),
    ] = (0.0,),
    settings: Annotated[
        tuple[str, ...],
        repeatable("--set", "KEY=VALUE", "Parameter of the driver: planner.clearance.now=0.3"),
    ] = (),
) -> CrowdNavBench:
    """Create the benchmark from its options.

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
