"""BARN worlds in this simulator: success, collisions and score of local planners.

A two-dimensional port: worlds, start, goal, limits and score are those of the benchmark, the robot
is this simulator's. Its figures are not comparable with figures from Gazebo.

Pictures of ``cohelm bench barn``.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cohelm import plugins
from cohelm.arrays import Floats, Integers
from cohelm.benchmarks.bench import (
    LOCAL_PLANNERS,
    BenchReport,
    Result,
    Sheet,
    Task,
    known_name,
    split_names,
    unset,
)
from cohelm.benchmarks.claims import (
    ENOUGH,
    OURS,
    Bound,
    Verdict,
    bounded,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.options import Settings, names
from cohelm.errors import ConfigError
from cohelm.evaluation.external.barn import (
    BarnOutcome,
    BarnWorlds,
    barn_setup,
    read_barn,
    ride_barn,
    score,
)
from cohelm.evaluation.report.statistics import wilson_share
from cohelm.plotting import canvas
from cohelm.plotting.route_panels import STYLES
from cohelm.recordings.outside_data import outside_data
from cohelm.stopwatch import Timing

SHOWN = 8
"""Number of worlds in the gallery, from the straightest to the most winding."""

_COLOURS = tuple(colour for colour, _, _ in STYLES)


def draw_difficulty(classes: Mapping[str, Sequence[float]], file: Path) -> Path:
    """Draw the share of successes in each class of difficulty.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = _figure(6.0, 3.4)
    axes = figure.subplots()
    for k, (planner, shares) in enumerate(classes.items()):
        at = np.arange(len(shares)) + 0.8 * (k + 0.5) / len(classes) - 0.4
        there, colour = np.isfinite(shares), _COLOURS[k % len(_COLOURS)]
        axes.bar(
            at[there], np.array(shares)[there], 0.74 / len(classes), label=planner, color=colour
        )
    count = len(next(iter(classes.values())))
    for k in range(count):
        if not any(np.isfinite(shares[k]) for shares in classes.values()):
            axes.annotate("none ridden", (k, 0.02), ha="center", fontsize=7, color=canvas.INK)
    words = ["straightest", *[""] * (count - 2), "most winding"]
    axes.set(ylim=(0.0, 1.0), xticks=range(count), xticklabels=words)
    axes.set_ylabel("success")
    axes.grid(axis="y", color=canvas.UNKNOWN, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title("BARN worlds, 2-D port: success by reference path, in fifths", fontsize=9)
    figure.legend(loc="outside lower center", ncols=min(len(classes), 4), fontsize=8)
    canvas.save(figure, file)
    return file


def draw_gallery(
    results: Mapping[str, Sequence[Result]], worlds: BarnWorlds, hardness: Floats, file: Path
) -> Path:
    """Draw some worlds with the tracks through them.

    Args:
        results: planner → rides with ``track`` (k, 2).
        worlds: the data.
        hardness: of each world, (n,); sorts the panels.
        file: to be written.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    # One panel per quantile of difficulty among the worlds that were ridden.
    ridden = sorted({r.row["world"] for each in results.values() for r in each})
    ridden.sort(key=lambda world: float(hardness[world]))
    picks = np.unique(np.linspace(0, len(ridden) - 1, min(SHOWN, len(ridden))).round().astype(int))
    figure = _figure(1.55 * len(picks) + 0.3, 3.9)
    for axes, pick in zip(
        np.ravel(figure.subplots(1, len(picks), squeeze=False)), picks, strict=True
    ):
        world = ridden[pick]
        discs = [Circle((x, y), worlds.radius) for x, y in worlds.cylinders[world]]
        axes.add_collection(PatchCollection(discs, facecolor=canvas.INK, linewidth=0.0))
        for k, (planner, each) in enumerate(results.items()):
            for ride in (r for r in each if r.row["world"] == world):
                won = ride.row["outcome"] == BarnOutcome.SUCCESS.value
                track, colour = ride.arrays["track"], _COLOURS[k % len(_COLOURS)]
                axes.plot(*track.T, color=colour, linewidth=1.4, label=planner)
                if not won:
                    axes.plot(*track[-1], marker="x", color=colour, markersize=9)
        axes.add_patch(Circle(tuple(worlds.goal), worlds.goal_tolerance, fill=False, ls=":"))
        axes.set(xlim=(-4.7, 0.2), ylim=(2.0, 14.1), aspect="equal", xticks=[], yticks=[])
        axes.set_title(f"{world}", fontsize=8)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8)
    canvas.save(figure, file)
    return file


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure


TITLE = "BARN worlds, a 2-D port (not comparable with the original in Gazebo)"
PLANNERS = (OURS, "dwa")
WORLDS = 300
CLASSES = 5
"""Number of classes of difficulty."""
REQUIRED = {OURS: Bound(low=0.95), "dwa": Bound(low=0.8)}
"""Share of successes over all worlds."""
COLUMNS = {
    "rides": ("rides", 0),
    "success": ("success", 3),
    "collision": ("collision", 3),
    "timeout": ("timeout", 3),
    "time": ("time of successes, s", 2),
    "score": ("score", 3),
    "score_until_2026": ("score, rule until March 2026", 3),
    "least_gap": ("minimum distance, m", 3),
    "replans": ("new paths", 1),
    "control_ms": ("plan, median ms", 1),
    "tick_ms": ("tick, median ms", 1),
}
"""Figure → heading and digits."""
_MEANS = ("score", "score_until_2026", "mean_speed", "least_gap", "replans", "held_time")

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class BarnBench:
    """The benchmark with some planners in some worlds."""

    planners: tuple[str, ...] = PLANNERS
    worlds: tuple[int, ...] = tuple(range(WORLDS))
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per world, planner and seed of the sensors' noise."""
        worlds = read_barn(outside_data())
        with tempfile.TemporaryDirectory() as folder:  # wrong settings fail here, not in a ride
            for planner in self.planners if self.settings else ():
                barn_setup(worlds, self.worlds[0], planner, Path(folder), self.settings)
        return [
            (world, planner, seed, self.settings)
            for world in self.worlds
            for planner in self.planners
            for seed in seeds
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride once."""
        return [_ride(*task)]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """One row per planner, success by difficulty, a gallery."""
        return barn_report(results, read_barn(outside_data()), folder)


def create(
    planners: Annotated[
        str | None,
        names("Local planners; default: ss_mpc_dcbf and dwa."),
    ] = None,
    worlds: Annotated[
        str | None,
        typer.Option(metavar="N|A,B", help="A number of worlds, or indices; default: all 300."),
    ] = None,
    settings: Settings = (),
) -> BarnBench:
    """Create the benchmark from its options.

    Raises:
        ConfigError: if a planner or a world does not exist.
    """
    unset(settings, LOCAL_PLANNERS)
    chosen = split_names(planners, "--planners") or PLANNERS
    for name in chosen:
        known_name(name, plugins.names("local_planners"), "local planner", "--planners")
    return BarnBench(planners=chosen, worlds=_numbers(worlds), settings=tuple(settings))


def _numbers(text: str | None) -> tuple[int, ...]:
    """Indices of the worlds that ``--worlds`` selects."""
    if text is None:
        return tuple(range(WORLDS))
    wrong = ConfigError(
        f"give a number of worlds, or indices with commas, each 0 to {WORLDS - 1}; not {text!r}",
        key="--worlds",
    )
    try:
        numbers = [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise wrong from None
    if not numbers:
        raise wrong
    if "," not in text:
        if not 1 <= numbers[0] <= WORLDS:
            raise wrong
        return tuple(range(0, WORLDS, WORLDS // numbers[0]))[: numbers[0]]
    if not all(0 <= number < WORLDS for number in numbers):
        raise wrong
    return tuple(dict.fromkeys(numbers))


def _ride(world: int, planner: str, seed: int, settings: tuple[str, ...]) -> Result:
    worlds = read_barn(outside_data())
    with tempfile.TemporaryDirectory() as folder:
        stage = barn_setup(worlds, world, planner, Path(folder), settings, seed=seed)
        ride = ride_barn(worlds, world, stage)
    optimal, time = worlds.optimal_time(world), float(ride.time[-1])
    success = ride.outcome is BarnOutcome.SUCCESS
    length = float(np.hypot(*np.diff(ride.pose[:, :2], axis=0).T).sum())
    row = {
        "world": world,
        "planner": planner,
        "seed": seed,
        "outcome": ride.outcome.value,
        "time": time,
        "optimal_time": optimal,
        "score": score(time, optimal) if success else 0.0,
        "score_until_2026": score(time, optimal, least=4.0) if success else 0.0,
        "length": length,
        "mean_speed": length / time if time > 0.0 else 0.0,
        "least_gap": max(ride.least_gap, 0.0),
        "held_time": ride.held_time,
        "replans": ride.replans,
        "tick_ms": Timing.of(ride.tick_time).median,
        "control_ms": Timing.of(ride.control_time).median,
        # The first call includes compilation.
        "control_p99_ms": Timing.of(ride.control_time[1:]).p99,
    }
    return Result(row=row, arrays={"track": ride.pose[:, :2]})


def barn_report(results: Sequence[Result], worlds: BarnWorlds, folder: Path) -> BenchReport:
    """Tables, verdicts, a summary and the pictures."""
    by_planner: dict[str, list[Result]] = {}
    for each in results:
        by_planner.setdefault(each.row["planner"], []).append(each)
    rows = {planner: [r.row for r in each] for planner, each in by_planner.items()}
    figures = {planner: _figures(each) for planner, each in rows.items()}
    hardness = difficulty(worlds)
    bounds = np.quantile(hardness, np.linspace(0.0, 1.0, CLASSES + 1)[1:-1])
    kind = np.digitize(hardness, bounds).astype(np.int64)
    classes = {planner: _by_class(each, kind) for planner, each in rows.items()}
    verdicts = [_verdict(name, rows[name]) for name in REQUIRED if name in rows]
    return BenchReport(
        sheets=(_table(figures), _class_table(classes), verdict_sheet(verdicts)),
        notes=(
            "a 2-D port of the worlds: not comparable with figures from Gazebo, and the score not "
            "with the one that was used until March 2026",
            *verdict_notes(verdicts),
        ),
        summary={
            "planners": figures,
            "success_by_difficulty": classes,
            "verdicts": verdict_summary(verdicts),
            "source": worlds.source,
        },
        files=(
            draw_difficulty(classes, folder / "difficulty.png"),
            draw_gallery(by_planner, worlds, hardness, folder / "gallery.png"),
        ),
    )


def difficulty(worlds: BarnWorlds) -> Floats:
    """Length of each world's reference path over the straight distance, (n,).

    The benchmark's own measure (a mean of five metrics along the path) is not in the data.
    """
    straight = float(np.hypot(*(worlds.goal - worlds.start[:2])))
    longer: Floats = worlds.length / straight
    return longer


def _figures(rows: Rows) -> dict[str, float]:
    """Shares and means over a planner's rides; the time is that of the successes."""
    outcomes = np.array([row["outcome"] for row in rows])
    won = outcomes == BarnOutcome.SUCCESS.value
    times = np.array([row["time"] for row in rows])
    return {
        "rides": float(len(rows)),
        **{each.value: float(np.mean(outcomes == each.value)) for each in BarnOutcome},
        "time": float(times[won].mean()) if won.any() else float("nan"),
        **{key: float(np.mean([row[key] for row in rows])) for key in _MEANS},
        "tick_ms": float(np.median([row["tick_ms"] for row in rows])),
        "control_ms": float(np.median([row["control_ms"] for row in rows])),
        "control_p99_ms": float(np.max([row["control_p99_ms"] for row in rows])),
    }


def _table(figures: Mapping[str, Mapping[str, float]]) -> Sheet:
    return Sheet(
        title="BARN worlds, 2-D port; means over the worlds; at best 0.5 and 0.25",
        columns=("planner", *(title for title, _ in COLUMNS.values())),
        rows=tuple(
            (planner, *(f"{each[key]:.{digits}f}" for key, (_, digits) in COLUMNS.items()))
            for planner, each in figures.items()
        ),
    )


def _by_class(rows: Rows, kind: Integers) -> list[float]:
    """Share of successes in each class of difficulty; NaN where nothing was ridden.

    kind: (n,) class of each world.
    """
    won = np.array([row["outcome"] == BarnOutcome.SUCCESS.value for row in rows])
    of = np.array([kind[row["world"]] for row in rows])
    return [float(won[of == k].mean()) if (of == k).any() else float("nan") for k in range(CLASSES)]


def _class_table(classes: Mapping[str, Sequence[float]]) -> Sheet:
    return Sheet(
        title="success by length of the reference path over the straight distance, in fifths",
        columns=("planner", "straightest", *(f"{k}." for k in range(2, CLASSES)), "most winding"),
        rows=tuple(
            (name, *("–" if math.isnan(v) else f"{v:.3f}" for v in each))
            for name, each in classes.items()
        ),
    )


def _verdict(planner: str, rows: Rows) -> Verdict:
    won = wilson_share(np.array([row["outcome"] == BarnOutcome.SUCCESS.value for row in rows]))
    remark = "too few worlds for a finding" if len(rows) < ENOUGH else ""
    return bounded(planner, "success", won.mean, REQUIRED[planner],
                   f"{won:.3f} in {len(rows)} rides", remark)  # fmt: skip
