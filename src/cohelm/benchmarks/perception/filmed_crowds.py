"""Perception on filmed crowds: tracked people, groups and predictions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from cohelm.benchmarks.bench import missing_data
from cohelm.benchmarks.claims import (
    Bound,
    measured,
    skipped,
)
from cohelm.errors import PluginError
from cohelm.evaluation.perception.crowd_scores import crowd_scores
from cohelm.evaluation.perception.filmed_crowd import REQUIRED
from cohelm.evaluation.perception.group_scores import group_scores
from cohelm.evaluation.perception.prediction_scores import (
    AHEAD,
    by_person,
    predict_film,
)
from cohelm.evaluation.perception.recording_view import parts_of, perception_of
from cohelm.evaluation.perception.tracked_film import TrackedFilm, track_film
from cohelm.evaluation.perception.tracking_scores import LEAST_VISIBLE
from cohelm.perception import Predictor
from cohelm.recordings import read_trajectories
from cohelm.recordings.outside_data import outside_file
from cohelm.stopwatch import Stopwatch, Timing
from cohelm.testing.scenes import walkers

FILMS = {"ETH": "eth_obsmat.txt", "zara01": "zara01_obsmat.txt"}
CROWDS = tuple((name, drive) for name in FILMS for drive in (False, True))
"""Film, and True where the chair drives."""


class PredictedFilm(NamedTuple):
    """A film on which predictions are scored."""

    file: str
    rates: tuple[float | None, ...] = (10.0, None)
    """Rates of the scans, Hz; None: the film's own."""
    ahead: float = AHEAD
    """Prediction time, s."""


PREDICTED = {
    **{name: PredictedFilm(file) for name, file in FILMS.items()},
    # Frames of HERMES lie 1/16 s apart.
    "HERMES": PredictedFilm("hermes_uo-050-180-180.txt", (10.0, 2.5), 1.25),
}
WINDOW = 60.0
"""Part of a film that every seed adds, s."""
LEAST_MOTA, LEAST_IDF1 = Bound(low=0.90), Bound(low=0.85)
MOST_ERROR, MOST_SLIP = Bound(high=0.10), Bound(high=0.20)
"""Position error, m, and velocity error, m/s."""
LEAST_PAIRS = Bound(low=0.80)
"""Pairwise F1 of groups."""


def crowd(
    name: str, drive: bool, first: int, count: int, settings: Sequence[str] = ()
) -> Iterator[dict[str, Any]]:
    """Film, or windows of it, replayed before the simulated LiDAR."""
    part = f"crowd {name}, chair {'driving' if drive else 'standing'}"
    file = _film(name)
    if file is None:
        yield skipped(part, "people tracked", missing_data("pedestrians", FILMS[name]))
        return
    walks = read_trajectories(file)
    start, end = WINDOW * first, min(WINDOW * (first + count), float(walks.time.max()))
    if end <= start:
        yield skipped(part, "people tracked", f"the film has ended by {start:.0f} s")
        return
    try:
        scores = crowd_scores(
            walks, seed=0, drive=drive, start=start, seconds=end - start,
            parts=perception_of(settings),
        )  # fmt: skip
    except PluginError as error:
        yield skipped(part, "people tracked", str(error))
        return
    found, who = scores.tracking, scores.tracking.identities
    ran = f"{start:.0f}–{end:.0f} s of {walks.time.max():.0f} s, {who.positions} sightings"
    seen = f"within {REQUIRED[1]:g} m, ≥ {LEAST_VISIBLE:.0%} visible"
    wrong = f"{who.misses} misses, {who.false} false, {who.switches} id changes"
    yield measured(part, "MOTA", who.mota, bound=LEAST_MOTA, remark=f"{ran}, {seen}")
    yield measured(part, "IDF1", who.idf1, bound=LEAST_IDF1, remark=wrong)
    yield measured(part, "position error", found.position_error, unit="m", bound=MOST_ERROR)
    yield measured(part, "velocity error", found.velocity_error, unit="m/s", bound=MOST_SLIP)
    median, p99 = 1e3 * np.percentile(scores.cost, [50.0, 99.0])
    yield measured(part, "a frame, median", median, unit="ms", remark=f"CPU time; p99 {p99:.1f} ms")


def groups(settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Pairs detected on whole films, frame by frame, compared with the lists of the films."""
    detector = parts_of(settings, ("group_detector",))["group_detector"]
    for name, film in FILMS.items():
        part, file = "groups", _film(name)
        walks = None if file is None else read_trajectories(file)
        if walks is None or not walks.groups:
            yield skipped(part, name, missing_data("pedestrians", film) + ", or its list of groups")
            continue
        scores = group_scores(walks, walks.groups, detector)
        low, high = scores.interval()
        said = (
            f"{type(detector).__name__}, the whole film: {scores.annotated} pairs listed, "
            f"{scores.found} detected, {scores.right} of them right; 95 % [{low:.2f}, {high:.2f}]"
        )
        yield measured(part, f"{name}, pairwise F1", scores.f1, bound=LEAST_PAIRS, remark=said)


def prediction(settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """Error and likelihood of the positions predicted some time before, on whole films."""
    predictor = _predictor(settings)
    for name, film in PREDICTED.items():
        file = outside_file("pedestrians", film.file)
        if file is None:
            yield skipped("prediction", name, missing_data("pedestrians", film.file))
            continue
        for rate in film.rates:
            scans = f"{name}, {'as filmed' if rate is None else f'{rate:g} Hz'}"
            watched = track_film(read_trajectories(file), rate=rate)
            yield from _predicted(scans, watched, predictor, film)


def _predicted(
    scans: str, watched: TrackedFilm, predictor: Predictor, film: PredictedFilm
) -> Iterator[dict[str, Any]]:
    part, name = "prediction", type(predictor).__name__
    seen = predict_film(watched, predictor, ahead=film.ahead)
    error, likely = by_person(seen.error, seen.person), seen.log_likelihood().mean()
    counts = f"{len(seen.person)} frames of {len(np.unique(seen.person))} people, the whole film"
    yield measured(
        part, f"{scans}: error at {film.ahead:g} s", error.mean, unit="m",
        remark=f"{name}: {counts}; 95 % [{error.low:.3f}, {error.high:.3f}]",
    )  # fmt: skip
    yield measured(
        part, f"{scans}: ln L at {film.ahead:g} s", likely, unit="ln 1/m²",
        remark=f"90 % regions hold {seen.within(0.9):.1%}",
    )  # fmt: skip


def cost(
    settings: Sequence[str] = (), people: int = 50, ticks: int = 200
) -> Iterator[dict[str, Any]]:
    """Thread CPU time of a prediction of many people over 25 steps."""
    predictor, memory, spent = _predictor(settings), None, []
    states = np.random.default_rng(0).normal(size=(people, 4))
    for k in range(ticks):
        states[:, :2] += 0.1 * states[:, 2:]
        tracked = walkers(states, time=0.1 * k)
        watch = Stopwatch()
        _, memory = predictor.predict(tracked, 25, 0.1, memory)
        spent.append(watch.elapsed())
    timing = Timing.of(spent[10:])
    name = f"{people} people, 25 steps, median"
    yield measured("prediction", name, timing.median, unit="ms", remark=f"p99 {timing.p99:.2f} ms")


def _predictor(settings: Sequence[str]) -> Predictor:
    made = parts_of(settings, ("predictor",))["predictor"]
    return cast("Predictor", made)


def _film(name: str) -> Path | None:
    return outside_file("pedestrians", FILMS[name])
