"""Random simulated scans with known people, to train the classifier of scan candidates.

A scene is a shipped floor, a scanner somewhere on it, furniture and aids of many kinds, and people.
Everything but the walls is a set of discs; see ``planar_bodies``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, read_only, value
from cohelm.maps import OccupancyGrid, read_floor_plan
from cohelm.messages import Scan
from cohelm.robots import LaserMount
from cohelm.scenarios.scenario import floor_file
from cohelm.simulation import generator
from cohelm.simulation.sensors import BodyKind, outline_of, sweep
from cohelm.simulation.sensors.planar_bodies import RADIUS, rod

FLOORS = ("corridors", "crossroads", "doorway", "hall", "hallway", "hospital", "two-rooms", "ward")
"""Floors that give the walls."""
MAX_FURNITURE, MAX_PEOPLE = 14, 7
NEAR, FAR = 0.5, 9.0
"""Distance of objects from the scanner, m."""
ON_BODY = 0.06
"""A return this near a person's outline is theirs, m."""
KINDS = {
    BodyKind.LEGS: 0.4,
    BodyKind.DISC: 0.3,
    BodyKind.CHILD: 0.08,
    BodyKind.SEATED: 0.07,
    BodyKind.WALKER: 0.05,
    BodyKind.WHEELCHAIR: 0.05,
    BodyKind.TROLLEY: 0.05,
}
"""Shares of outlines among people (assumed)."""


@value
class TrainingScan:
    """A scan, the pose of its robot, and the outlines of people."""

    scan: Scan
    pose: Annotated[Floats, Shape("3")]
    people: Annotated[Floats, Shape("k 3")]
    """Discs x, y, radius, map frame, m."""

    def of_people(self, points: Floats) -> Booleans:
        """Mask (p,) of returns (p, 2) that lie on a person."""
        if not len(self.people):
            return np.zeros(len(points), dtype=np.bool_)
        apart = np.hypot(*(points[:, None] - self.people[None, :, :2]).transpose(2, 0, 1))
        out: Booleans = (apart - self.people[:, 2]).min(axis=1) < ON_BODY
        return out


def training_scan(seed: int) -> TrainingScan:
    """Draw one scene and sweep it once."""
    rng = generator(seed, "training scene")
    grid, free = _floor(FLOORS[int(rng.integers(len(FLOORS)))])
    pose = np.array([*free[rng.integers(len(free))], rng.uniform(-math.pi, math.pi)])
    near = free[np.hypot(*(free - pose[:2]).T) < FAR]
    things = [_furniture(rng, _place(near, pose, rng)) for _ in range(rng.integers(MAX_FURNITURE))]
    if rng.random() < 0.3:
        things.append(_knees(pose, rng))
    people = [_person(rng, _place(near, pose, rng)) for _ in range(rng.integers(MAX_PEOPLE))]
    blank = np.empty((0, 3))
    persons = np.concatenate([blank, *people])
    mount = LaserMount(
        beams=int(rng.integers(300, 1100)),
        field_of_view_deg=float(rng.choice([180.0, 270.0, 360.0])),
        noise=float(rng.uniform(0.003, 0.025)),
        dropout=float(rng.uniform(0.0, 0.03)),
    )
    discs = np.concatenate([persons, *things])
    scan = sweep(mount, grid, discs, pose, time=0.0, rng=rng)
    return TrainingScan(scan=scan, pose=pose, people=persons)


@lru_cache(maxsize=16)
def _floor(name: str) -> tuple[OccupancyGrid, Floats]:
    """Grid, and the centres (k, 2) of its free cells, m."""
    grid = read_floor_plan(floor_file(name)).draw()[0]
    rows, cols = np.nonzero(grid.data == 0)
    centres = (np.column_stack([cols, rows]) + 0.5) * grid.resolution
    c, s = math.cos(grid.X_MG[2]), math.sin(grid.X_MG[2])
    return grid, read_only(centres @ np.array([[c, s], [-s, c]]) + grid.X_MG[:2])


def _place(free: Floats, pose: Floats, rng: np.random.Generator) -> Floats:
    """Pose (3,) of an object, at least ``NEAR`` from the scanner."""
    at = free[rng.integers(len(free), size=20)]
    away = at[np.hypot(*(at - pose[:2]).T) > NEAR + 0.4]
    at = away[0] if len(away) else pose[:2] + 2.0
    return np.array([*at, rng.uniform(-math.pi, math.pi)])


def _at(pose: Floats, discs: Floats) -> Floats:
    """Discs of an object at its pose."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y, r = discs.T
    return np.column_stack([pose[0] + c * x - s * y, pose[1] + s * x + c * y, r])


def _person(rng: np.random.Generator, pose: Floats) -> Floats:
    kind = rng.choice(len(KINDS), p=list(KINDS.values()))
    chosen = list(KINDS)[kind]
    swing = float(rng.choice([0.0, 1.0]) * rng.uniform(-0.35, 0.35))
    discs = outline_of(chosen, swing, RADIUS[chosen] * float(rng.uniform(0.75, 1.15)))
    if chosen is not BodyKind.DISC:
        legs = discs[:, 2] > 0.03
        discs = discs * np.where(legs[:, None], [1.0, 1.0, rng.uniform(0.75, 1.4)], 1.0)
    return _at(pose, discs)


def _knees(pose: Floats, rng: np.random.Generator) -> Floats:
    """Knees and feet of the rider in front of a scanner behind them."""
    ahead, apart = rng.uniform(0.15, 0.4), rng.uniform(0.06, 0.15)
    return _at(pose, np.array([[ahead, apart, 0.06], [ahead, -apart, 0.06]]))


def _furniture(rng: np.random.Generator, pose: Floats) -> Floats:
    make: Sequence[Callable[[np.random.Generator], Floats]] = (
        _chair, _chair, _table, _stool, _post, _post, _box, _box, _leaf, _pram, _empty_aid,
        _clutter,
    )  # fmt: skip
    return _at(pose, make[int(rng.integers(len(make)))](rng))


def _corners(length: float, width: float, radius: float) -> Floats:
    half = [(sx * length / 2, sy * width / 2, radius) for sx in (1, -1) for sy in (1, -1)]
    return np.array(half)


def _chair(rng: np.random.Generator) -> Floats:
    side = rng.uniform(0.36, 0.5)
    return _corners(side, side * rng.uniform(0.9, 1.1), rng.uniform(0.01, 0.03))


def _table(rng: np.random.Generator) -> Floats:
    return _corners(rng.uniform(0.7, 1.8), rng.uniform(0.5, 0.9), rng.uniform(0.015, 0.05))


def _stool(rng: np.random.Generator) -> Floats:
    """Office chair: a post and five casters."""
    turn = np.arange(5) * 2.0 * math.pi / 5.0
    feet = np.column_stack([0.3 * np.cos(turn), 0.3 * np.sin(turn), np.full(5, 0.025)])
    return np.vstack([feet, [0.0, 0.0, rng.uniform(0.02, 0.05)]])


def _post(rng: np.random.Generator) -> Floats:
    """Post, bin, plant or column."""
    return np.array([[0.0, 0.0, rng.choice([0.03, 0.06, 0.1, 0.15, 0.35]) * rng.uniform(0.8, 1.2)]])


def _box(rng: np.random.Generator) -> Floats:
    """Cupboard, radiator, bed end or bag."""
    x, y = rng.uniform(0.1, 1.2) / 2.0, rng.uniform(0.1, 0.6) / 2.0
    ring = [(x, y), (-x, y), (-x, -y), (x, -y), (x, y)]
    return np.concatenate([rod(a, b) for a, b in pairwise(ring)])


def _leaf(rng: np.random.Generator) -> Floats:
    """Leaf of a door, or a panel."""
    return rod((0.0, 0.0), (rng.uniform(0.3, 1.0), 0.0))


def _pram(rng: np.random.Generator) -> Floats:
    wheels = _corners(rng.uniform(0.5, 0.8), rng.uniform(0.4, 0.6), 0.05)
    return (
        np.concatenate([wheels, rod((-0.3, 0.2), (-0.3, -0.2))]) if rng.random() < 0.5 else wheels
    )


def _empty_aid(rng: np.random.Generator) -> Floats:
    """Rollator, wheelchair or trolley without its user."""
    kinds = (BodyKind.WALKER, BodyKind.WHEELCHAIR, BodyKind.TROLLEY)
    return outline_of(kinds[int(rng.integers(3))], 0.0, 0.25)[2:]


def _clutter(rng: np.random.Generator) -> Floats:
    """Things lying about: up to eight small ones within half a metre."""
    n = int(rng.integers(2, 9))
    return np.column_stack([rng.uniform(-0.5, 0.5, (n, 2)), rng.uniform(0.01, 0.08, n)])
