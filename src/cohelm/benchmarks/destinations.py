"""Destination inference on rides with hidden destinations.

Each ride is scored at a quarter, half and three quarters of the way: is the right place the most
probable one, or among three? A ranking of the places by their distance is the baseline. A wrong
offer is a wrong place whose belief rises above 0.8 or 0.9. With ``elsewhere`` the destination has
no name, and every such offer is wrong.

The rider follows a planned path with the stick of one of the disturbed riders of the simulator. The
chair is a unicycle with limits of acceleration that slides along walls; nobody else is there. This
is much cheaper than the whole simulator, and the inference sees what it would see in it: poses with
the noise of a localiser, and the stick.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats, value
from cohelm.benchmarks.bench import (
    BenchReport,
    Result,
    Sheet,
    Task,
    known_name,
    missing_data,
    split_names,
)
from cohelm.benchmarks.options import names, repeatable
from cohelm.config import override, validate
from cohelm.errors import ConfigError, PlanningError
from cohelm.maps import (
    DistanceField,
    MapWarning,
    NamedPlace,
    OccupancyGrid,
    Places,
    distance_field,
    read_floor_plan,
    read_map,
)
from cohelm.navigation import DestinationInference, DestinationParameters
from cohelm.planning import CostToGo, RouteProblem, cost_to_go
from cohelm.recordings.outside_data import outside_file
from cohelm.robots import Robot, load_robot
from cohelm.scenarios.scenario import floor_file
from cohelm.sharing import stick_twist
from cohelm.simulation import RiderView, generator

MAPS = "ros_maps"
"""Folder of the floors in COHELM_DATA."""
RIDERS = ("noisy", "tremor", "laggy", "uncooperative")
"""Riders that take turns from seed to seed; each disturbs a rider who pursues the path."""
GOALS = ("uniform", "habits", "elsewhere")
"""``uniform``: every place is equally likely; ``habits``: by Zipf's law, and the inference knows
earlier rides; ``elsewhere``: a point that no place names."""
ZIPF = 1.2
"""Exponent of the law by which a rider with habits chooses."""
EARLIER = 50
"""Earlier rides of a rider with habits."""
PLACES = 24
"""Places that are drawn on a floor without names."""
SHORTEST = 8.0
"""Shortest way to the destination, m."""
PERIOD = 0.05
"""s."""
_BODY, _CLEARANCE = 0.3, 0.6  # radius that slides along walls; distance of drawn places to walls, m
_POSE_NOISE = 0.01  # standard deviation of the localiser, m
_DEAD_ZONE, _SPEED = 0.05, 0.8  # of a rider's profile by default; m/s
_TRIES = 200


@value
class PlacesFloor:
    """A floor with its places, and all that rides on it share."""

    name: str
    grid: OccupancyGrid
    places: Places
    walls: DistanceField
    fields: CostToGo
    robot: Robot


class HiddenGoal(NamedTuple):
    """Destination of one ride."""

    path: Floats
    """Planned path to it (k, 2), m."""
    place: int
    """Index of the place; −1: it has no name."""
    habits: dict[str, int]
    """Earlier rides by name of the place; empty: not known."""


@value
class RiddenTrack:
    """A ride, as the inference sees it, every 0.05 s."""

    poses: Floats
    """(k, 3) with the noise of the localiser."""
    sticks: Floats
    """(k, 2) forward, left; 0 within the dead zone."""
    arrived: bool


@lru_cache(maxsize=2)
def places_floor(name: str) -> PlacesFloor:
    """Load a floor of cohelm or of COHELM_DATA, and name places on it where it has none.

    Raises:
        ConfigError: if there is no such floor.
    """
    robot = load_robot("quantum_q6_edge")
    grid, places = _drawing(name)
    if not len(places):
        places = _drawn_places(grid, name)
    points = np.array([place.point for place in places])
    fields = cost_to_go(grid, robot.inscribed_radius + 0.05, points)
    walls = distance_field(grid)
    return PlacesFloor(name=name, grid=grid, places=places, walls=walls, fields=fields, robot=robot)


def floor_exists(name: str) -> None:
    """Check that a floor can be read.

    Raises:
        ConfigError: if not; says whether its data are missing.
    """
    folder = outside_file(MAPS)
    known = sorted(file.stem for file in folder.glob("*.yaml")) if folder is not None else []
    if name in known:
        return
    try:
        floor_file(name)
    except ConfigError as cause:
        more = f", or of {MAPS}: {', '.join(known)}" if known else f"; {missing_data(MAPS)}"
        raise ConfigError(f"{cause.problem}{more}", key="--floors") from None


def draw_goal(floor: PlacesFloor, goals: str, seed: int) -> HiddenGoal | None:
    """Draw start, destination and habits of a seed; None where no two are far enough apart."""
    rng = generator(seed, f"destinations on {floor.name}")
    n = len(floor.places)
    order = rng.permutation(n)
    chance = np.full(n, 1.0 / n)
    if goals == "habits":
        chance[order] = 1.0 / np.arange(1, n + 1) ** ZIPF
        chance /= chance.sum()
    counts = rng.multinomial(EARLIER, chance) if goals == "habits" else np.zeros(n, dtype=int)
    habits = {name: int(k) for name, k in zip(floor.places.names, counts, strict=True) if k}
    points = np.array([place.point for place in floor.places])
    for _ in range(_TRIES):
        place = int(rng.choice(n, p=chance)) if goals != "elsewhere" else -1
        end = points[place] if place >= 0 else _unnamed_point(floor, rng)
        start = points[int(rng.integers(n))]
        if float(np.hypot(*(end - start))) < SHORTEST / 2.0:
            continue
        path = _path(floor, start, end)
        if path is not None and _length(path) >= SHORTEST:
            return HiddenGoal(path, place, habits)
    return None


def drive(floor: PlacesFloor, goal: HiddenGoal, rider: str, seed: int) -> RiddenTrack:
    """Drive along the path with a rider of the simulator.

    Args:
        floor: walls and robot.
        goal: the path.
        rider: one of ``RIDERS``.
        seed: of all randomness.
    """
    rng, noise = generator(seed, "rider"), generator(seed, "localiser")
    base = {"use": "ideal", "avoids_obstacles": False}
    model = plugins.build("riders", {"use": rider, "base": base})
    robot, path, memory = floor.robot, goal.path, None
    pose = np.array([*path[0], rng.uniform(-math.pi, math.pi)])
    twist, poses, sticks = np.zeros(3), [], []
    steps = int((30.0 + 5.0 * _length(path)) / PERIOD)
    for step in range(steps):
        view = RiderView(time=step * PERIOD, pose=pose, twist=twist, goal=path[-1], route=path)
        act = model.act(view, memory, rng)
        memory = act.memory
        stick = act.command.deflection if act.command is not None else np.zeros(2)
        if math.hypot(*stick) <= _DEAD_ZONE:
            stick = np.zeros(2)
        poses.append(pose + np.array([*noise.normal(0.0, _POSE_NOISE, 2), 0.0]))
        sticks.append(stick)
        if float(np.hypot(*(path[-1] - pose[:2]))) < 0.3:
            return RiddenTrack(poses=np.array(poses), sticks=np.array(sticks), arrived=True)
        twist = _accelerated(twist, stick_twist(stick, robot, _SPEED), robot)
        pose = _moved(pose, twist, floor.walls)
    return RiddenTrack(poses=np.array(poses), sticks=np.array(sticks), arrived=False)


def _accelerated(twist: Floats, wanted: Floats, robot: Robot) -> Floats:
    limit = PERIOD * np.array([robot.max_deceleration, 1.0, robot.max_turn_acceleration])
    out: Floats = twist + np.clip(wanted - twist, -limit, limit)
    return out


def _moved(pose: Floats, twist: Floats, walls: DistanceField) -> Floats:
    """Next pose; a chair that touches a wall is moved along it."""
    middle = pose[2] + 0.5 * PERIOD * twist[2]
    way = PERIOD * twist[0] * np.array([math.cos(middle), math.sin(middle)])
    point = pose[:2] + way
    distance, gx, gy = walls.with_gradient(point)
    if distance < _BODY:
        point = point + (_BODY - distance) * np.array([gx, gy])
    return np.array([*point, pose[2] + PERIOD * twist[2]])


def _path(floor: PlacesFloor, start: Floats, end: Floats) -> Floats | None:
    planner = plugins.build("global_planners", "astar")
    problem = RouteProblem(
        grid=floor.grid, robot=floor.robot, start=start, goal=end, clearance=0.05
    )
    try:
        points: Floats = planner.plan(problem).points
    except PlanningError:
        return None
    return points


def _unnamed_point(floor: PlacesFloor, rng: np.random.Generator) -> Floats:
    """A free point that is at least 3 m from every place."""
    rows, cols = np.nonzero(floor.fields.free & (floor.fields.cost.min(axis=2) > 3.0))
    k = int(rng.integers(len(rows)))
    size = floor.fields.resolution / floor.grid.resolution
    cell = ((np.array([rows[k], cols[k]]) + 0.5) * size).astype(int)
    return floor.grid.centres(cell)


def _drawing(name: str) -> tuple[OccupancyGrid, Places]:
    floor_exists(name)
    file = outside_file(MAPS, f"{name}.yaml")
    if file is None:
        return read_floor_plan(floor_file(name)).draw()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        return read_map(Path(file)), Places()


def _drawn_places(grid: OccupancyGrid, name: str) -> Places:
    """Places as far apart as possible: each one is the point farthest from those before."""
    clear = distance_field(grid).distance >= _CLEARANCE
    cells = np.argwhere(clear)
    # The largest connected part: the others are shafts and the outside of the building.
    first = generator(0, f"places on {name}")
    fields = []
    best: tuple[int, int] = (0, 0)
    for k in first.permutation(len(cells))[:10].tolist():
        point = grid.centres(cells[k])
        reach = cost_to_go(grid, _CLEARANCE, point[None]).cost[..., 0]
        best = max(best, (int((reach < 1e5).sum()), k))
    points = [grid.centres(cells[best[1]])]
    centres = grid.centres(cells)
    while len(points) < PLACES:
        fields.append(_at_all(cost_to_go(grid, _CLEARANCE, points[-1][None]), centres))
        least = np.min(fields, axis=0)
        least[least > 1e5] = -1.0
        points.append(centres[int(np.argmax(least))])
    return Places(
        places=tuple(NamedPlace(name=f"Place {k + 1}", point=p) for k, p in enumerate(points)),
        source=name,
    )


def _at_all(field: CostToGo, points: Floats) -> Floats:
    """Cost (m,) in the cells of points (m, 2), m."""
    grid = OccupancyGrid(
        data=np.zeros(field.free.shape, dtype=np.int8),
        resolution=field.resolution,
        X_MG=field.X_MG,
    )
    rows, cols = grid.cells(points).T
    out: Floats = field.cost[rows, cols, 0].astype(float)
    return out


def _length(path: Floats) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


SHARES = (0.25, 0.5, 0.75)
"""Shares of the way at which the ranking is scored."""
CERTAIN = 0.8
"""Belief that counts as certainty."""
WRONG = (0.8, 0.9)
"""Beliefs from which a wrong place counts as a wrong offer."""
_RELEASE = 0.15  # a place must fall this much below before it counts again


@value
class Beliefs:
    """Beliefs and costs-to-go along a ride of k steps."""

    belief: Floats
    """(k, n)."""
    cost: Floats
    """(k, n), m."""
    offered: tuple[tuple[int, ...], ...]
    """Indices of the offered places at each step."""


def beliefs_of(floor: PlacesFloor, track: RiddenTrack, inference: DestinationInference) -> Beliefs:
    """Run the inference along a ride."""
    memory, belief, cost, offered = None, [], [], []
    index = {name: k for k, name in enumerate(floor.places.names)}
    turn_rate = floor.robot.max_turn_rate
    for k, (pose, stick) in enumerate(zip(track.poses, track.sticks, strict=True)):
        found, memory = inference.update(k * PERIOD, pose, stick, turn_rate, memory)
        belief.append(found.places)
        cost.append(floor.fields.at(pose[:2]))
        offered.append(tuple(index[offer.name] for offer in found.offers))
    return Beliefs(belief=np.array(belief), cost=np.array(cost), offered=tuple(offered))


def score(along: Beliefs, place: int, near: float) -> dict[str, float]:
    """Scores of a ride; those of the right place are NaN where the destination has no name.

    Args:
        along: beliefs of the ride.
        place: index of the destination; −1: it has no name.
        near: places closer than this are not offered, m.
    """
    row = {"seconds": PERIOD * (len(along.belief) - 1)}
    for bound in WRONG:
        row[f"wrong_{bound:g}"] = float(_wrong(along, place, near, bound))
    new = [set(b) - set(a) for a, b in zip(along.offered, along.offered[1:], strict=False)]
    row["new_offers"] = float(len(along.offered[0]) + sum(map(len, new)))
    return row | _right(along, place, near)


def _wrong(along: Beliefs, place: int, near: float, bound: float) -> int:
    """Number of times that the belief in a wrong place rises above a bound."""
    count, shown = 0, -1
    best = np.argmax(np.where(along.cost >= near, along.belief, 0.0), axis=1)
    for k, i in enumerate(best.tolist()):
        if shown >= 0 and along.belief[k, shown] < bound - _RELEASE:
            shown = -1
        if i != shown and along.belief[k, i] > bound and along.cost[k, i] >= near:
            shown = i
            count += i != place
    return count


def _right(along: Beliefs, place: int, near: float) -> dict[str, float]:
    """Ranks of the right place along the way, and when it became certain."""
    row: dict[str, float] = {}
    for share in SHARES:
        percent = f"{100.0 * share:.0f}"
        k = _at_share(along, place, share)
        other = np.where(along.cost[k] >= near, along.cost[k], np.inf)
        ranks = {"": _rank(-along.belief[k], place), "nearest_": _rank(other, place)}
        for name, rank in ranks.items():
            row[f"{name}top1_{percent}"] = float(rank < 1) if place >= 0 else math.nan
            row[f"{name}top3_{percent}"] = float(rank < 3) if place >= 0 else math.nan
        row[f"offered_{percent}"] = float(place in along.offered[k]) if place >= 0 else math.nan
    certain = np.flatnonzero(along.belief[:, place] > CERTAIN) if place >= 0 else np.empty(0)
    row["certain"] = float(len(certain) > 0) if place >= 0 else math.nan
    first = int(certain[0]) if len(certain) else -1
    row["certain_metres_left"] = float(along.cost[first, place]) if len(certain) else math.nan
    left = PERIOD * (len(along.belief) - 1 - first)
    row["certain_seconds_left"] = left if len(certain) else math.nan
    return row


def _at_share(along: Beliefs, place: int, share: float) -> int:
    """First step at which this share of the way to the place is done."""
    cost = along.cost[:, place]
    return int(np.argmax(cost <= (1.0 - share) * cost[0])) if place >= 0 else 0


def _rank(values: Floats, place: int) -> int:
    """Number of places before this one; places of equal value count half."""
    if place < 0:
        return len(values)
    before = int((values < values[place]).sum())
    return before + int((values == values[place]).sum() - 1) // 2


TITLE = "Destination inference: hidden destinations of simulated riders"
FLOORS = ("hospital", "utexas_gdc_3ne")
"""The floors by default; no parameter was tuned on them."""
_PERCENT = tuple(f"{100.0 * share:.0f}" for share in SHARES)


@dataclass(frozen=True)
class DestinationsBench:
    """The benchmark on some floors."""

    floors: tuple[str, ...]
    goals: tuple[str, ...] = GOALS
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of :class:`DestinationParameters`."""
    TITLE: str = TITLE
    SEEDS: int = 200
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per ride."""
        return [
            (floor, goals, seed) for floor in self.floors for goals in self.goals for seed in seeds
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Drive, infer, score."""
        name, goals, seed = task
        floor, rider = places_floor(name), RIDERS[seed % len(RIDERS)]
        goal = draw_goal(floor, goals, seed)
        if goal is None:
            return []
        parameters = _parameters((*self.settings, f"inference.habits={goal.habits}"))
        inference = DestinationInference(floor.fields, floor.places.names, parameters)
        track = drive(floor, goal, rider, seed)
        along = beliefs_of(floor, track, inference)
        row = {
            "floor": name,
            "goals": goals,
            "seed": seed,
            "rider": rider,
            "places": len(floor.places),
            "arrived": float(track.arrived),
        }
        return [Result(row | score(along, goal.place, parameters.offers.near))]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Tables of each floor."""
        rows = [result.row for result in results]
        sheets = []
        for floor in dict.fromkeys(str(row["floor"]) for row in rows):
            there = [row for row in rows if row["floor"] == floor]
            groups = {goals: [r for r in there if r["goals"] == goals] for goals in self.goals}
            title = f"{floor}, {there[0]['places']} places"
            sheets += [_ranking(title, groups), _offers(title, groups)]
        lost = sum(1 for row in rows if not row["arrived"])
        notes = [
            "Riders pursue a planned path with a disturbed stick, alone on the floor: "
            f"{', '.join(RIDERS)} in turn."
        ]
        notes += [
            f"{floor}: no two places are {SHORTEST:g} m apart"
            for floor in self.floors
            if floor not in {row["floor"] for row in rows}
        ]
        if lost:
            notes.append(f"{lost} of {len(rows)} rides did not arrive; they are scored as well.")
        return BenchReport(tuple(sheets), tuple(notes), {"settings": list(self.settings)})


def create(
    floors: Annotated[
        str | None,
        names("Floors of cohelm or of ros_maps in COHELM_DATA; default: hospital, utexas_gdc_3ne."),
    ] = None,
    goals: Annotated[
        str | None,
        names("uniform, habits, elsewhere (a point without a name); default: all."),
    ] = None,
    settings: Annotated[
        tuple[str, ...],
        repeatable("--set", "KEY=VALUE", "Parameter: inference.beta=2 or offers.show=0.1"),
    ] = (),
) -> DestinationsBench:
    """Create the benchmark from its options.

    Raises:
        ConfigError: if a floor, a kind of destination or a setting does not exist.
    """
    names = split_names(floors, "--floors") or tuple(
        name for name in FLOORS if name == FLOORS[0] or outside_file(MAPS, f"{name}.yaml")
    )
    for name in names:
        floor_exists(name)
    kinds = split_names(goals, "--goals") or GOALS
    for kind in kinds:
        known_name(kind, GOALS, "kind of destination", "--goals")
    _parameters(settings)
    return DestinationsBench(names, kinds, tuple(settings))


def _parameters(settings: Sequence[str]) -> DestinationParameters:
    return validate(DestinationParameters, override({}, settings))


def _ranking(title: str, groups: Mapping[str, Sequence[Mapping[str, Any]]]) -> Sheet:
    """Share of rides in which the right place is the first, or one of the first three."""
    lines = []
    for goals, rows in groups.items():
        if goals == "elsewhere" or not rows:
            continue
        for name, prefix in (("inference", ""), ("nearest place", "nearest_")):
            cells = [
                _share(rows, f"{prefix}{top}_{share}")
                for top in ("top1", "top3")
                for share in _PERCENT
            ]
            lines.append((f"{goals}, {name}", str(len(rows)), *cells))
    columns = tuple(f"{top} at {share} %" for top in ("first", "of three") for share in _PERCENT)
    return Sheet(f"{title}: right place", ("destinations", "rides", *columns), tuple(lines))


def _offers(title: str, groups: Mapping[str, Sequence[Mapping[str, Any]]]) -> Sheet:
    """Certainty, and what the rider is shown."""
    lines = [
        (
            goals,
            _share(rows, f"offered_{_PERCENT[1]}"),
            _share(rows, "certain"),
            _median(rows, "certain_metres_left"),
            _median(rows, "certain_seconds_left"),
            *(_mean(rows, f"wrong_{bound:g}", 2) for bound in WRONG),
            _mean(rows, "new_offers", 1),
            _mean(rows, "seconds", 0),
        )
        for goals, rows in groups.items()
        if rows
    ]
    columns = (
        "destinations",
        "offered at 50 %",
        f"belief > {CERTAIN:g}",
        "then left, m",
        "then left, s",
        *(f"wrong at {bound:g} a ride" for bound in WRONG),
        "new offers a ride",
        "ride, s",
    )
    return Sheet(f"{title}: certainty and offers", columns, tuple(lines))


def _values(rows: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    return [float(row[key]) for row in rows if not math.isnan(row[key])]


def _share(rows: Sequence[Mapping[str, Any]], key: str) -> str:
    values = _values(rows, key)
    return f"{100.0 * float(np.mean(values)):.0f} %" if values else ""


def _mean(rows: Sequence[Mapping[str, Any]], key: str, digits: int) -> str:
    values = _values(rows, key)
    return f"{float(np.mean(values)):.{digits}f}" if values else ""


def _median(rows: Sequence[Mapping[str, Any]], key: str) -> str:
    values = _values(rows, key)
    return f"{float(np.median(values)):.1f}" if values else ""
