"""Lifts, niches, toilets, dead ends and side doors: does a chair get in, and out again?

Everything is drawn from the seed: sizes, door, start, destination. A chair that starts inside faces
the far wall. Half of the destinations inside are where the axle is after entering backwards, with a
hall in front in which a chair can turn. The chairs differ in where their drive axle is.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from cohelm.benchmarks.bench import chosen_names, unset
from cohelm.benchmarks.claims import NONE, Bound
from cohelm.benchmarks.options import Settings, names
from cohelm.benchmarks.ride_claims import Requirement
from cohelm.benchmarks.rides.report import ReportSpec, ride_report
from cohelm.benchmarks.study import Study, ride_all
from cohelm.evaluation.sweeps import RideTask
from cohelm.robots import Robot, load_robot
from cohelm.simulation import generator

TITLE = "Manoeuvres in narrow places"
CHAIRS = ("quantum_q6_edge", "rear_drive")
COMPARED = {
    "start": "the seed",
    "goal": "the seed",
    "robot": "--robots",
    **{f"floor_plan.{part}": "the seed" for part in ("corridors", "rooms", "doors", "furniture")},
}
"""Keys that cannot be set for all rides → what sets them."""
CLAIMS = tuple(
    Requirement(figure, bound, contender=chair, pooled="all places")
    for chair in CHAIRS
    for figure, bound in (("reached", Bound(low=0.98)), ("contacts", NONE))
)
"""Requirements, written down before the rides."""
SPEC = ReportSpec(
    title=TITLE,
    claims=CLAIMS,
    measures=("reached", "wall_collision", "time", "path_length", "stop_rate", "heading_change"),
    compared=("reached", "time", "stop_rate"),
    by=("scene", "robot"),
    base=CHAIRS[0],
    limitations=("Nobody else is there; the chair drives alone, by its scanner and the map.",),
)
_CENTRE, _WALL = 6.0, 0.1
_BELOW = 0.5
"""Lower edge of the hall, m."""
_GAP, _ROOM = 0.07, 0.25
"""Bounds of the gap between a chair inside and the far wall, m."""
_TURNING = 2.0
"""Width of a hall before a place that is entered backwards, at least, m."""


class NarrowPlace(NamedTuple):
    """Narrow place above a hall; lengths between wall surfaces, m."""

    width: float
    depth: float
    door: float
    """Clear width of its door, 0: open over its whole width."""
    hall: float
    """Width of the hall."""
    aside: float = 0.0
    """Offset of door and chair from the middle of the place."""
    basin: tuple[float, float] | None = None
    """Width and depth of a basin in the far corner on the other side."""


def _lift(rng: np.random.Generator) -> NarrowPlace:
    size = ((1.1, 1.4), (1.0, 1.3))[rng.integers(2)]
    return NarrowPlace(*size, door=_drawn(rng, 0.8, 0.9), hall=_drawn(rng, 1.5, 2.4))


def _dead_end(rng: np.random.Generator) -> NarrowPlace:
    width, depth = _drawn(rng, 0.8, 1.3), _drawn(rng, 2.0, 6.0)
    return NarrowPlace(width, depth, door=0.0, hall=_drawn(rng, 1.5, 2.4))


def _niche(rng: np.random.Generator) -> NarrowPlace:
    width, depth = _drawn(rng, 0.9, 1.3), _drawn(rng, 1.2, 1.6)
    return NarrowPlace(width, depth, door=0.0, hall=_drawn(rng, 1.5, 2.4))


def _toilet(rng: np.random.Generator) -> NarrowPlace:
    side = float(rng.choice([-1.0, 1.0]))
    hall = _drawn(rng, 1.5, 2.4)
    basin = (0.45, _drawn(rng, 0.3, 0.4))
    return NarrowPlace(1.5, 1.5, _drawn(rng, 0.85, 0.95), hall, 0.225 * side, basin)


def _side_door(rng: np.random.Generator) -> NarrowPlace:
    size = _drawn(rng, 1.8, 2.4), _drawn(rng, 1.8, 2.4)
    return NarrowPlace(*size, door=_drawn(rng, 0.85, 0.95), hall=_drawn(rng, 1.2, 1.5))


PLACES: dict[str, Callable[[np.random.Generator], NarrowPlace]] = {
    "lift": _lift,
    "dead end": _dead_end,
    "niche": _niche,
    "toilet": _toilet,
    "side door": _side_door,
}


def draw(place: str, way: str, robot: Robot, seed: int) -> tuple[str, ...]:
    """Draw floor, start and destination of a ride as settings of the scenario ``lift``.

    Args:
        place: key of ``PLACES``.
        way: ``in`` or ``out``.
        robot: its footprint decides where it may stand.
        seed: of the ride; another chair gets the same floor.
    """
    rng = generator(seed, f"manoeuvres/{place}/{way}")
    size, backwards = PLACES[place](rng), way == "in" and bool(rng.integers(2))
    if backwards:  # the chair must be able to turn before the place
        size = size._replace(hall=max(size.hall, _TURNING))
    far = _BELOW + size.hall + (_WALL if size.door else 0.0) + size.depth
    front, rear = float(robot.outline[:, 0].max()), float(-robot.outline[:, 0].min())
    # the middle of a small place, or before the end of a deep one
    gap = min(max(0.5 * (size.depth - front - rear), _GAP), _ROOM)
    inside = (_CENTRE + size.aside, far - gap - (rear if backwards else front))
    x = _CENTRE + float(rng.choice([-1.0, 1.0])) * float(rng.uniform(0.5, 4.0))
    hall, turned = (x, _BELOW + 0.5 * size.hall), float(rng.uniform(-3.0, 3.0))
    if way == "out":
        start, goal = (*inside, 90.0 + turned), hall
    else:
        start, goal = (*hall, turned + (0.0 if x < _CENTRE else 180.0)), inside
    values: dict[str, Any] = {
        "floor_plan": _floor(size, far),
        "start": [round(each, 3) for each in start],
        "goal": [round(each, 3) for each in goal],
    }
    return tuple(f"{key}={json.dumps(each)}" for key, each in values.items())


def _floor(size: NarrowPlace, far: float) -> dict[str, Any]:
    """Changes to the floor ``lift``."""
    half, wall = 0.5 * size.width + 0.5 * _WALL, 0.5 * _WALL
    top = _BELOW + size.hall + wall
    # an open place overlaps the hall, so that there is no wall between
    below = top if size.door else top - 2.0 * _WALL
    rect = [_CENTRE - half, below, _CENTRE + half, far + wall]
    hall = {"Hall": {"rect": [_BELOW - wall, _BELOW - wall, 12.0 - _BELOW + wall, top]}}
    room = {"Lift": {"rect": rect, "point": None}}
    basins = []
    if size.basin is not None:
        x = _CENTRE - math.copysign(0.5 * size.width, size.aside)
        edges = sorted((x, x + math.copysign(size.basin[0], size.aside)))
        basins = [{"name": "basin", "rect": [edges[0], far - size.basin[1], edges[1], far]}]
    return {
        "corridors": hall,
        "rooms": room,
        "doors": [{"at": [_CENTRE + size.aside, top], "width": size.door}] if size.door else [],
        "furniture": basins,
        "places": {},
    }


def _drawn(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a length on the cells of the floor, m."""
    return round(round(float(rng.uniform(low, high)) / 0.05) * 0.05, 3)


def create(
    robots: Annotated[
        str | None,
        names("Robots by name or file; default: quantum_q6_edge and rear_drive."),
    ] = None,
    places: Annotated[
        str | None,
        names("lift, dead end, niche, toilet, side door; default: all."),
    ] = None,
    settings: Settings = (),
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, ScenarioError: if a robot, a place or a setting does not exist.
    """
    unset(settings, COMPARED)
    found = chosen_names(places, "--places", PLACES, kind="place", known=PLACES)
    chairs = chosen_names(robots, "--robots", CHAIRS)
    return Study(
        TITLE,
        partial(_plan, chairs, found, tuple(settings)),
        partial(ride_report, spec=SPEC),
        partial(ride_all, empty_floor=False),
        SEEDS=10,
    ).checked()


def _plan(
    robots: Sequence[str], places: Sequence[str], settings: tuple[str, ...], seeds: range
) -> list[tuple[RideTask, ...]]:
    """One task per seed, place and direction, with the rides of all chairs."""
    return [
        tuple(
            RideTask(
                columns=(("scene", f"{place}, {way}"), ("robot", robot)),
                scenario="lift",
                settings=(
                    f"robot={robot}",
                    *draw(place, way, load_robot(robot), seed),
                    *settings,
                ),
                seed=seed,
            )
            for robot in robots
        )
        for seed in seeds
        for place in places
        for way in ("in", "out")
    ]
