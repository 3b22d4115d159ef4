"""Lost or not: drives on real floors, of which a part is carried elsewhere without notice.

A simple follower drives the planned route among people and furniture that the map lacks; only the
health monitor is judged. It goes on driving when the monitor would stop, so that one drive gives
the whole curve of detections against false alarms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet, Task
from cohelm.benchmarks.rides.calm import floor_files
from cohelm.benchmarks.rides.floor_draws import SCENARIO, draw_ride, floor_settings, known_floor
from cohelm.errors import PlanningError, ScenarioError
from cohelm.evaluation.report.statistics import wilson_share
from cohelm.geometry import inverse, transform
from cohelm.health import HealthParameters, HealthState, beam_map, monitor
from cohelm.maps import distance_field
from cohelm.messages import Decision, Reason
from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.scenario import load_scenario
from cohelm.simulation import World, generator

WITHIN = 2.0
"""Time within which a carry must be detected, s."""
BINS = (0.5, 1.0, 2.0, 5.0, 10.1)
"""Bounds of the distances of a carry, m."""
THRESHOLDS = np.linspace(0.05, 2.5, 50)
"""Scores at which the curve is drawn; 1 is the bound of being lost."""
_APART = 1.0
"""Time between two crossings of a threshold that are two alarms, s."""


class RocPoint(NamedTuple):
    """Point of the curve."""

    threshold: float
    detected: float
    """Share of the carries of 1 m and more that are detected in time."""
    alarms: float
    """False alarms per hour."""


def lost_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Detections by distance and false alarms of the whole monitor; curve of scan against map."""
    done = [each for each in results if not each.row["error"]]
    carried = [each for each in done if _is_carried(each.row)]
    hours = sum(_sound_time(each.row) for each in done) / 3600.0
    false = [each.row for each in done if _is_false(each.row)]
    curve = roc([each.row for each in done], [each.arrays["series"] for each in done])
    rate = len(false) / hours if hours else math.nan
    high = stats.chi2.ppf(0.975, 2 * len(false) + 2) / 2.0 / hours if hours else math.nan
    far = [each.row for each in carried if float(each.row["distance"]) >= 1.0]
    share = wilson_share(np.array([_delay(row) <= WITHIN for row in far], dtype=bool))
    notes = (
        f"{len(done)} drives on {len({each.row['floor'] for each in done})} floors, "
        f"{len(carried)} of them carried",
        f"carries of 1 m and more detected within {WITHIN:g} s: {share:.3f} of {len(far)}",
        f"false alarms: {len(false)} in {hours:.2f} h, {rate:.2f} an hour, "
        f"at most {high:.2f} (95 %)",
    )
    return BenchReport(
        sheets=(_sheet([each.row for each in carried]),),
        notes=notes,
        summary={
            "drives": len(done),
            "carried": len(carried),
            "detected_1m": share.mean,
            "alarms_per_hour": rate,
            "hours": hours,
            "curve": [point._asdict() for point in curve],
            "false": [f"{row['floor']} {row['seed']}" for row in false],
        },
    )


def roc(rows: Sequence[Mapping[str, Any]], series: Sequence[Floats]) -> list[RocPoint]:
    """Curve of the fit of scan and map, with breaks of the view, over multiples of the bounds."""
    p, out = HealthParameters(), []
    scores = [
        np.max(each[:, 1:] / [p.lost_share, p.lost_offset, p.lost_turn, p.break_fall], axis=1)
        for each in series
    ]
    hours = sum(_sound_time(row) for row in rows) / 3600.0
    for threshold in THRESHOLDS:
        hits, trials, alarms = 0, 0, 0
        for row, each, score in zip(rows, series, scores, strict=True):
            sound = each[:, 0] < (float(row["at"]) if _is_carried(row) else math.inf)
            alarms += _crossings(each[sound, 0], score[sound] >= threshold)
            if _is_carried(row) and float(row["distance"]) >= 1.0:
                trials += 1
                due = ~sound & (each[:, 0] <= float(row["at"]) + WITHIN)
                hits += bool((score[due] >= threshold).any())
        out.append(
            RocPoint(float(threshold), hits / max(trials, 1), alarms / hours if hours else 0.0)
        )
    return out


def _sheet(rows: Sequence[Mapping[str, Any]]) -> Sheet:
    out = []
    for low, high in pairwise(BINS):
        group = [row for row in rows if low <= float(row["distance"]) < high]
        delays = np.array([_delay(row) for row in group], dtype=float)
        share = wilson_share(np.asarray(delays <= WITHIN))
        found = delays[np.isfinite(delays)]
        out.append(
            (
                f"{low:g} to {high:g}",
                str(len(group)),
                f"{share.mean:.3f} [{share.low:.3f}, {share.high:.3f}]",
                f"{np.median(found):.2f}" if len(found) else "–",
            )
        )
    return Sheet(
        title=f"carried chairs that are stopped within {WITHIN:g} s",
        columns=("distance, m", "drives", "detected [95 %]", "median delay, s"),
        rows=tuple(out),
    )


def _is_carried(row: Mapping[str, Any]) -> bool:
    return float(row["carried"]) > 0.0


def _sound_time(row: Mapping[str, Any]) -> float:
    return (
        min(float(row["at"]), float(row["duration"]))
        if _is_carried(row)
        else float(row["duration"])
    )


def _is_false(row: Mapping[str, Any]) -> bool:
    found = float(row["found"])
    return math.isfinite(found) and (not _is_carried(row) or found < float(row["at"]))


def _delay(row: Mapping[str, Any]) -> float:
    delay = float(row["found"]) - float(row["at"])
    return delay if delay >= 0.0 else math.inf


def _crossings(time: Floats, above: np.ndarray) -> int:
    """Number of times at which a condition begins, at least a second apart."""
    starts = time[np.flatnonzero(above & ~np.concatenate([[False], above[:-1]]))]
    if not len(starts):
        return 0
    count, last = 1, starts[0]
    for start in starts[1:]:
        if start - last > _APART:
            count, last = count + 1, start
    return count


TITLE = "Lost or not: localisation health on real floors"
LONGEST = 20.0
"""Longest drive, s."""
AFTER = 3.0
"""Time after a carry, s; the detection must come within 2 s."""
SPEED, LOOK_AHEAD = 0.7, 0.8
"""Of the follower, m/s and m."""
CARRY = (4.0, 10.0)
"""Range of the time of a carry, s."""
DISTANCE = (0.5, 10.0)
"""Range of its distance, m, drawn evenly in its logarithm."""
PEOPLE = 20
"""Largest number of people."""
FURNITURE = 4
"""Boxes beside the route that the map lacks."""
DETECTING = frozenset(
    {
        *(Reason.LOST, Reason.SCAN_MOTION, Reason.POSE_FAULT, Reason.SENSORS_DISAGREE),
        *(Reason.ODOMETRY_FAULT, Reason.SCAN_IMPLAUSIBLE, Reason.SCAN_FROZEN, Reason.DRIVE_FAULT),
    }
)
"""Findings that stop the chair for sensors that contradict each other."""


class LostDrive(NamedTuple):
    """One drive: the seed decides on people, furniture and the carry."""

    floor: str
    seed: int


@dataclass(frozen=True)
class LostBench:
    """The benchmark."""

    TITLE: str = TITLE
    SEEDS: int = 100
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per floor and seed."""
        return [(LostDrive(file.stem, seed),) for seed in seeds for file in floor_files()]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Drive; a floor without space for the drawn drive gives no row."""
        out = [_drive(each) for each in task]
        return [each for each in out if each is not None]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Detections by distance, false alarms, and the curve of both."""
        return lost_report(results, folder)


def _drive(drive: LostDrive) -> Result | None:
    file = next(each for each in floor_files() if each.stem == drive.floor)
    rng = generator(drive.seed, f"lost on {drive.floor}")
    people = int(rng.integers(0, PEOPLE + 1))
    carried = bool(rng.random() < 0.5)
    at = round(float(rng.uniform(*CARRY)), 2)
    distance = float(np.exp(rng.uniform(*np.log(DISTANCE))))
    fault = f"faults=[{{kind: kidnapped, at: {at}, duration: 100, magnitude: {distance:.3f}}}]"
    setup = _setup(file, drive.seed, people, (fault,) if carried else (), rng)
    if setup is None:
        return None
    series, found, moved = follow(setup, drive.seed, at if carried else math.inf)
    row = {
        "floor": drive.floor,
        "seed": drive.seed,
        "people": people,
        "carried": float(carried and moved > 0.0),
        "distance": moved,
        "at": at,
        "duration": float(series[-1, 0]),
        "found": found,
        "error": "",
    }
    return Result(row, {"series": series})


def _setup(
    file: Path, seed: int, people: int, faults: tuple[str, ...], rng: np.random.Generator
) -> RideSetup | None:
    """Scenario of a drive, with furniture beside its route; None where there is no space."""
    draw = draw_ride(file, _known_floor(file), seed)
    if draw is None:
        return None
    common = (*floor_settings(file, draw), "people.see_robot=true")
    try:
        route = build_scenario(load_scenario(SCENARIO, [*common, "people.count=0"]), seed).route
        boxes = ", ".join(_boxes(route.points, rng))
        settings = [*common, f"people.count={people}", f"obstacles=[{boxes}]", *faults]
        return build_scenario(load_scenario(SCENARIO, settings), seed)
    except (ScenarioError, PlanningError):
        return None


def _boxes(points: Floats, rng: np.random.Generator) -> list[str]:
    """Square boxes about 1.2 m beside random points of the route."""
    out = []
    for _ in range(FURNITURE):
        i = int(rng.integers(0, len(points) - 1))
        along = points[i + 1] - points[i]
        left = np.array([-along[1], along[0]]) / max(math.hypot(*along), 1e-6)
        x, y = points[i] + rng.choice([-1.0, 1.0]) * rng.uniform(1.1, 1.6) * left
        side = rng.uniform(0.3, 0.7)
        out.append(f"{{at: [{x:.2f}, {y:.2f}], size: [{side:.2f}, {side:.2f}]}}")
    return out


def follow(setup: RideSetup, seed: int, carried_at: float) -> tuple[Floats, float, float]:
    """Drive the route with the monitor watching, up to a contact.

    The follower avoids nobody; who is in the chair would be within its scanner.

    Returns:
        (series (k, 5): time, contradiction, offset of the best fit (m), its turn (rad), fall of
        the share on walls after a break of the view;
        time of the first finding that would stop the chair, NaN: none;
        distance by which the chair was carried, m).
    """
    world = World(setup.world, seed)
    known = beam_map(setup.grid, distance_field(setup.grid))
    request, p = setup.request, setup.navigator.health
    state: HealthState | None = None
    rows, found, moved = [], math.nan, 0.0
    last = world.truth.pose
    while True:
        observation, truth = world.observe(), world.truth
        step = float(np.hypot(*(truth.pose[:2] - last[:2])))
        moved, last = max(moved, step if step > 0.2 else 0.0), truth.pose
        health, state = monitor(observation, request, setup.robot, known, state, p)
        where = health.localisation
        far = float(np.hypot(*where.offset[:2]))
        turn = abs(float(where.offset[2]))
        fall = max((each.continuity.fall for each in state.scanners if each), default=0.0)
        rows.append((observation.time, where.contradiction, far, turn, fall))
        if math.isnan(found) and any(each.reason in DETECTING for each in health.findings):
            found = observation.time
        end = min(LONGEST, carried_at + AFTER)
        near = np.hypot(*(observation.pose[:2] - setup.request.goal)) < 0.5
        met = bool(truth.hit_moving.any() or truth.hit_standing.any())
        hit = met or (truth.hit_wall and truth.time > carried_at)
        if truth.time >= end or near or hit:
            return np.array(rows), found, moved
        world.advance(Decision(twist=_pursue(observation.pose, setup.route.points)))


def _pursue(pose: Floats, points: Floats) -> Floats:
    """Twist (3,) of pure pursuit along a polyline (k, 2)."""
    apart = np.hypot(*(points - pose[:2]).T)
    i = int(np.argmin(apart))
    beyond = np.flatnonzero(apart[i:] >= LOOK_AHEAD)
    target = points[i + int(beyond[0])] if len(beyond) else points[-1]
    x, y = transform(inverse(pose), target)
    angle = math.atan2(y, x)
    turn = min(max(2.0 * angle, -1.0), 1.0)
    speed = SPEED * max(0.0, 1.0 - abs(angle) / 0.8)
    return np.array([speed, 0.0, turn])


def create() -> LostBench:
    """Create the benchmark.

    Raises:
        ConfigError: if the maps are missing.
    """
    floor_files()
    return LostBench()


_known_floor = lru_cache(maxsize=32)(known_floor)
