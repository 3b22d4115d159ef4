"""Perception on filmed crowds: who is told, who belongs together, where they will be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import cast

import numpy as np

from cohelm.errors import PluginError
from cohelm.evaluation.benches.perception_rows import Row, absent, not_run, row
from cohelm.evaluation.changes_of_mind import SOON, changes, noticed
from cohelm.evaluation.foresight import alarms, foresee, likelihoods
from cohelm.evaluation.grouping import group_scores
from cohelm.evaluation.perceived import ASKED
from cohelm.evaluation.perceived_crowds import crowd_scores
from cohelm.evaluation.perceived_scores import LEAST_VISIBLE
from cohelm.evaluation.watched import Watched, watch
from cohelm.evaluation.watching import parts_of, perception_of
from cohelm.perception import Predictor
from cohelm.recordings import read_trajectories
from cohelm.recordings.outside import outside_file

FILMS = {"ETH": "eth_obsmat.txt", "zara01": "zara01_obsmat.txt"}
CROWDS = tuple((name, drive) for name in FILMS for drive in (False, True))
"""Film, and whether the chair drives."""
WINDOW = 60.0
"""Of a film that every seed adds, s."""
LEAST_MOTA, LEAST_IDF1, MOST_ERROR, MOST_SLIP = 0.90, 0.85, 0.10, 0.20
LEAST_PAIRS = 0.80
"""Pairwise F1."""
MOST_ALARMS = 0.05
"""Share of frames in which something else than going on is said of who goes on."""
LEAST_NOTICED = 1.0
"""Share of the changes of mind."""


def crowd(
    name: str, drive: bool, first: int, count: int, settings: Sequence[str] = ()
) -> Iterator[Row]:
    """A film, or windows of it, walked through the simulated LiDAR."""
    part = f"crowd {name}, chair {'driving' if drive else 'standing'}"
    file = _film(name)
    if file is None:
        yield not_run(part, "people told", absent("pedestrians", FILMS[name]))
        return
    walks = read_trajectories(file)
    start, end = WINDOW * first, min(WINDOW * (first + count), float(walks.time.max()))
    if end <= start:
        yield not_run(part, "people told", f"the film has ended by {start:.0f} s")
        return
    try:
        scores = crowd_scores(
            walks, seed=0, drive=drive, start=start, seconds=end - start,
            parts=perception_of(settings),
        )  # fmt: skip
    except PluginError as error:
        yield not_run(part, "people told", str(error))
        return
    found, who = scores.tracking, scores.tracking.identities
    ran = f"{start:.0f}–{end:.0f} s of {walks.time.max():.0f} s, {who.positions} sightings"
    seen = f"within {ASKED[1]:g} m, ≥ {LEAST_VISIBLE:.0%} visible"
    wrong = f"{who.misses} misses, {who.false} false, {who.switches} id changes"
    yield row(part, "MOTA", who.mota, least=LEAST_MOTA, remark=f"{ran}, {seen}")
    yield row(part, "IDF1", who.idf1, least=LEAST_IDF1, remark=wrong)
    yield row(part, "position error", found.position_error, unit="m", most=MOST_ERROR)
    yield row(part, "velocity error", found.velocity_error, unit="m/s", most=MOST_SLIP)
    median, p99 = 1e3 * np.percentile(scores.cost, [50.0, 99.0])
    yield row(part, "a frame, median", median, unit="ms", remark=f"CPU time; p99 {p99:.1f} ms")


def groups(settings: Sequence[str] = ()) -> Iterator[Row]:
    """Pairs found on whole films, frame by frame, against the lists of those who filmed them."""
    detector = parts_of(settings, ("group_detector",))["group_detector"]
    for name, film in FILMS.items():
        part, file = "groups", _film(name)
        walks = None if file is None else read_trajectories(file)
        if walks is None or not walks.groups:
            yield not_run(part, name, absent("pedestrians", film) + ", or its list of groups")
            continue
        scores = group_scores(walks, walks.groups, detector)
        low, high = scores.interval()
        said = (
            f"{type(detector).__name__}, the whole film: {scores.noted} pairs noted, "
            f"{scores.found} found, {scores.right} of them right; 95 % [{low:.2f}, {high:.2f}]"
        )
        yield row(part, f"{name}, pairwise F1", scores.f1, least=LEAST_PAIRS, remark=said)


def prediction(settings: Sequence[str] = ()) -> Iterator[Row]:
    """How likely the true positions were held 1.2 s before, on whole films."""
    predictor = _predictor(settings)
    for name, film in FILMS.items():
        file = _film(name)
        if file is None:
            yield not_run("prediction", name, absent("pedestrians", film))
            continue
        for rate in (10.0, None):
            seen = f"{name}, {'as filmed' if rate is None else f'{rate:g} Hz'}"
            yield from _foreseen(seen, watch(read_trajectories(file), rate=rate), predictor)


def _foreseen(seen: str, watched: Watched, predictor: Predictor) -> Iterator[Row]:
    part, who = "prediction", type(predictor).__name__
    found, said = likelihoods(watched, predictor), alarms(foresee(watched, predictor))
    counts = f"{found.frames} frames of {found.people} people, the whole film"
    yield row(
        part, f"{seen}: ln L at 1.2 s", found.mean.mean, unit="ln 1/m²",
        remark=f"{who}: {counts}; 90 % regions hold {found.within_90:.1%}",
    )  # fmt: skip
    rivals = {"average weights": found.over_usual, "weights by hindsight": found.over_fixed,
              "constant velocity": found.over_constant}  # fmt: skip
    for rival, gain in rivals.items():
        yield row(
            part, f"{seen}: over {rival}", gain.low, least=0.0, right=gain.low > 0.0,
            remark=f"gain {gain.mean:.3f}, of which the lower end of the 95 % interval over people",
        )  # fmt: skip
    yield row(
        part, f"{seen}: false alarms", said.share, most=MOST_ALARMS,
        remark=f"{said.false} of {said.frames} frames; {said.said} alarms in all",
    )  # fmt: skip


def maneuvers(settings: Sequence[str] = ()) -> Iterator[Row]:
    """How soon it is noticed that simulated walkers stop and turn."""
    predictor = _predictor(settings)
    found = noticed(changes(seed=0), predictor)
    for names, what in (("", "all"), ("stops", "stops"), ("turns", "turns")):
        meant = np.array([each.startswith(names) for each in found.names])
        late = float(np.quantile(found.delay[meant], 0.95, method="higher"))
        within = f"95 % within {late:.2f} s" if math.isfinite(late) else "more than 5 % never"
        yield row(
            "changes of mind", f"{what}, share noticed within {SOON:g} s", found.share(names),
            least=LEAST_NOTICED if not names else None,
            remark=f"{type(predictor).__name__}: {meant.sum()} simulated; {within}",
        )  # fmt: skip
    yield row(
        "changes of mind", "said before anything changed", found.early / max(found.ticks, 1),
        remark=f"{found.early} of {found.ticks} ticks",
    )  # fmt: skip


def _predictor(settings: Sequence[str]) -> Predictor:
    made = parts_of(("predictor.use=hypotheses", *settings), ("predictor",))["predictor"]
    return cast("Predictor", made)


def _film(name: str) -> Path | None:
    return outside_file("pedestrians", FILMS[name])
