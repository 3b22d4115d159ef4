"""SocNav1: measures of the distance to people beside ratings of people (Manso et al. 2020).

A rater sees a robot that stands in a room among people and says from 0 to 100 how acceptable its
place is. No measure is fitted to the ratings but the space between people and what they look at,
whose two parameters are chosen on the training scenes; the other scenes judge it.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from scipy.stats import rankdata

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Task, missing_data
from cohelm.benchmarks.claims import measured, measured_sheets
from cohelm.errors import ConfigError
from cohelm.evaluation.metrics.people import group_depth, person_depth
from cohelm.evaluation.report.statistics import bootstrap
from cohelm.geometry import distance_to_polygon
from cohelm.recordings.outside_data import outside_file
from cohelm.social.personal_space import PersonalSpace

TITLE = "Rank correlation (Spearman, 95 % interval) of measures of distance with people's ratings"
FOLDER, TRAINING, OTHERS = "socnav1", "socnav_training_small.json", "socnav_dev.json"
DISTANCE, DEPTH = "nearest person", "depth in personal space"
WEIGHTS, WIDTHS = (0.5, 0.7, 1.0), (0.15, 0.25, 0.35, 0.5)
"""Depth between a person and what they look at, and its standard deviation, m, to choose from."""


class RatedScene(NamedTuple):
    """One scene, the robot at the origin; n people."""

    score: float
    people: Floats
    """(n, 4) x, y, m, and velocity, which is 0."""
    heading: Floats
    """(n,) rad."""
    pairs: tuple[tuple[int, int], ...]
    """People who talk to each other."""
    links: Floats
    """(m, 2, 2) ends of the lines between people, and between people and things, m."""


def read_scenes(file: Path) -> list[RatedScene]:
    """Read scenes, one JSON object a line.

    Raises:
        ConfigError: naming the line that is no scene.
    """
    scenes = []
    for k, line in enumerate(file.read_bytes().splitlines(), start=1):
        if line.strip():
            try:
                scenes.append(_scene(json.loads(line)))
            except (ValueError, KeyError, TypeError) as error:
                problem = f"line {k} is no scene of SocNav1 ({type(error).__name__}: {error})"
                raise ConfigError(problem, file=file) from None
    if not scenes:
        raise ConfigError("has no scenes", file=file)
    return scenes


def _scene(given: Mapping[str, Any]) -> RatedScene:
    number = {each["id"]: i for i, each in enumerate(given["humans"])}
    place = {
        each["id"]: (each["xPos"] / 100.0, each["yPos"] / 100.0)
        for each in (*given["humans"], *given["objects"])
    }
    people = np.zeros((len(number), 4))
    people[:, :2] = np.reshape([place[each] for each in number], (-1, 2))
    linked = [(a, b) for a, b, _ in given["links"] if a in place and b in place]
    # An orientation of 0 faces −y.
    heading = np.radians([each["orientation"] - 90.0 for each in given["humans"]])
    score = float(given["score"])
    if not (np.isfinite(people).all() and np.isfinite(heading).all() and 0.0 <= score <= 100.0):
        raise ValueError("a number is not finite, or the score is not 0 to 100")
    return RatedScene(
        score,
        people,
        heading,
        tuple((number[a], number[b]) for a, b in linked if a in number and b in number),
        np.reshape([[place[a], place[b]] for a, b in linked], (-1, 2, 2)),
    )


def distance(scene: RatedScene) -> float:
    """Distance from the robot's centre to the nearest person, m."""
    return float(np.hypot(*scene.people[:, :2].T).min(initial=math.inf))


def depth(scene: RatedScene) -> float:
    """Deepest depth in a personal space, 0…1; Xu et al., eq. (5)."""
    return float(_depths(scene).max(initial=0.0))


def gap(scene: RatedScene) -> float:
    """Smallest distance to a contour of personal space, m: the gap of the objective, eq. (8)."""
    away, form = np.hypot(*scene.people[:, :2].T), PersonalSpace.Parameters()
    with np.errstate(divide="ignore"):
        extent = away * np.sqrt(form.contour_scale / -np.log(_depths(scene)))
    return float((away - extent).min(initial=math.inf))


def group(scene: RatedScene) -> float:
    """Deepest depth in the space of a person or of two who talk."""
    at, pairs = np.zeros((1, 2)), map(list, scene.pairs)
    shared = (group_depth(at, scene.people[None, p], scene.heading[None, p]) for p in pairs)
    return max(depth(scene), *(float(each[0]) for each in shared), 0.0)


def between(scene: RatedScene, weight: float, width: float) -> float:
    """Deepest depth in the space of a person, or between one and what they look at."""
    away = np.array([distance_to_polygon(each, 0.0, 0.0) for each in scene.links])
    line = weight * np.exp(-0.5 * (away / width) ** 2)
    return max(depth(scene), float(line.max(initial=0.0)))


def _depths(scene: RatedScene) -> Floats:
    depths: Floats = person_depth(np.zeros((1, 2)), scene.people[None], scene.heading[None])[0]
    return depths


def spearman(x: Floats, y: Floats, axis: int = -1) -> Any:
    """Rank correlation of samples along an axis."""
    a, b = (rankdata(each, axis=axis) for each in (x, y))
    a, b = (each - each.mean(axis=axis, keepdims=True) for each in (a, b))
    return (a * b).sum(axis=axis) / np.sqrt((a**2).sum(axis=axis) * (b**2).sum(axis=axis))


@dataclass(frozen=True)
class RatedScenesBench:
    """The benchmark; seeds have no meaning in it."""

    scenes: Path | None = None
    """Scenes that judge; None: those in COHELM_DATA."""
    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One.

        Raises:
            ConfigError: if scenes are missing, or a file has none.
        """
        self._scenes()
        return [(FOLDER,)]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Rows of figures."""
        return [Result(row) for row in _rows(*self._scenes())]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per set of scenes."""
        rows = [each.row for each in results]
        return BenchReport(measured_sheets(rows), (), {})

    def _scenes(self) -> tuple[list[RatedScene], list[RatedScene]]:
        """(training scenes, others)."""
        training = outside_file(FOLDER, TRAINING)
        others = self.scenes or outside_file(FOLDER, OTHERS)
        if training is None or others is None:
            raise ConfigError(missing_data(FOLDER), key="bench socnav1")
        return read_scenes(training), read_scenes(others)


def create(
    *,
    scenes: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Other rated scenes; default: those in COHELM_DATA."),
    ] = None,
) -> RatedScenesBench:
    """Create the benchmark.

    Raises:
        ConfigError: if there is no such file.
    """
    if scenes is not None and not scenes.is_file():
        raise ConfigError("there is no such file", file=scenes)
    return RatedScenesBench(scenes)


def _rows(training: Sequence[RatedScene], others: Sequence[RatedScene]) -> Iterator[Any]:
    scores = np.array([each.score for each in training])
    weight, width = max(
        itertools.product(WEIGHTS, WIDTHS),
        key=lambda pair: spearman(np.array([-between(each, *pair) for each in training]), scores),
    )
    fitted = f"or between a person and what they look at (weight {weight:g}, σ {width:g} m)"
    measures: Mapping[str, Callable[[RatedScene], float]] = {
        DISTANCE: distance,
        "gap to the contour of personal space": gap,
        DEPTH: lambda scene: -depth(scene),
        "depth in personal or group space": lambda scene: -group(scene),
        f"depth in personal space, {fitted}": lambda scene: -between(scene, weight, width),
    }
    for part, chosen in (("training scenes", training), ("other scenes", others)):
        ratings = np.array([each.score for each in chosen])
        values = {name: np.array([f(each) for each in chosen]) for name, f in measures.items()}
        for name, each in values.items():
            low, high = bootstrap((each, ratings), spearman)
            remark = f"[{low:.3f}, {high:.3f}], {len(chosen)} scenes"
            rho = float(spearman(each, ratings))
            yield measured(part, name, rho, remark=remark)
        low, high = bootstrap((values[DEPTH], values[DISTANCE], ratings), _better)
        better = float(_better(values[DEPTH], values[DISTANCE], ratings))
        yield measured(part, f"{DEPTH} − {DISTANCE}", better, remark=f"[{low:.3f}, {high:.3f}]")


def _better(one: Floats, other: Floats, ratings: Floats, axis: int = -1) -> Any:
    return spearman(one, ratings, axis) - spearman(other, ratings, axis)
