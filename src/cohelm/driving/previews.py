"""What a wish would cost: asked of a planner in a process of its own, so that nobody waits for it.

It plans twice among the same things, with the wish and without it, and tells the difference.
"""

from __future__ import annotations

import os
import pickle
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection

import numpy as np

from cohelm.arrays import Floats, identical
from cohelm.driving.asking import Charge, Points, Ready
from cohelm.driving.shown import way_of
from cohelm.errors import PlanningError
from cohelm.evaluation import Stage
from cohelm.evaluation.processes import end_with_owner, leave_interrupts
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Crowding, LiveObstacles, Path, Request, Wish
from cohelm.navigation import Tick, reason_of
from cohelm.planning import GlobalPlanner, RouteProblem

_YIELDS = 10
"""How much more willingly than the navigator this process waits for a processor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What the chair's way is planned among, besides the map."""

    pose: Floats
    """(3,), X_MR."""
    goal: Floats
    """(2,), m."""
    wishes: tuple[Wish, ...]
    """Those that are still ahead."""
    wished_from: Floats
    """Where they were set, (2,), m."""
    clearance: float
    """m."""
    live: LiveObstacles | None
    crowding: Crowding | None


@dataclass(frozen=True, slots=True, kw_only=True)
class WhatIf:
    """A question: what the way would be with one wish more."""

    id: int
    client: str
    wish: Wish
    surroundings: bytes
    """Pickled :class:`Surroundings`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Price:
    """Its answer."""

    id: int
    client: str
    points: Points = ()
    length: float = 0.0
    """m."""
    extra: float = 0.0
    """Metres more than without the wish."""
    trouble: str = ""
    """Why there is no way; empty where there is one."""


def surroundings_of(tick: Tick, asked: Request) -> bytes:
    """A tick's, pickled; nothing where it leads nowhere.

    Args:
        tick: the last one.
        asked: what is wanted now; the tick's own request, unless time has stood still since.
    """
    memory = tick.memory
    if np.isnan(asked.goal).any():
        return b""
    route = memory.route if identical(asked.wishes, tick.request.wishes) else None
    here = tick.observation.pose
    told = memory.crowding.told if memory.crowding is not None else None
    found = Surroundings(
        pose=here,
        goal=asked.goal,
        wishes=route.wishes if route is not None else asked.wishes,
        wished_from=route.wished_from if route is not None else here[:2],
        clearance=asked.profile.clearance,
        live=memory.obstacles.obstacles if memory.obstacles is not None else None,
        crowding=told if told is not None and told.density.any() else None,
    )
    return pickle.dumps(found, protocol=5)


def serve_previews(pipe: Connection, charge: Charge) -> None:
    """What the process does, until the other end of the pipe is gone."""
    leave_interrupts()
    end_with_owner()
    stage = set_stage(charge.scenario, charge.seed)
    os.nice(_YIELDS)
    _warm(stage)
    try:
        pipe.send(Ready(done=True))
        while True:
            pipe.send(price(pipe.recv(), stage))
    except (EOFError, OSError):
        return


def wishes_to_try(stage: Stage) -> tuple[Wish, ...]:
    """One of each kind, so that all that wishes need is compiled and read before anybody waits."""
    middle = stage.route.points[len(stage.route.points) // 2]
    aside = middle + np.array([0.5, 0.5])
    return (
        Wish(points=aside[None]),  # a point on the way asks for nothing
        Wish(kind="stroke", points=np.array([middle, aside])),
        Wish(kind="avoid", points=middle[None], radius=0.5),
    )


def _warm(stage: Stage) -> None:
    """Price each of them once, among a thing and people that are there for this only."""
    start, asked, grid = stage.route.points[0], stage.request, stage.grid
    thing = np.zeros((40, 40), dtype=np.uint8)
    thing[30:33, 30:33] = 1
    about = Surroundings(
        pose=np.array([*start, 0.0]),
        goal=asked.goal,
        wishes=(),
        wished_from=start,
        clearance=asked.profile.clearance,
        live=LiveObstacles(corner=np.array(grid.cells(start)), occupied=thing, version=1),
        crowding=Crowding(
            density=np.full((4, 4), 0.1, dtype=np.float32),
            resolution=1.0,
            X_MG=np.array([*start, 0.0]),
            version=1,
        ),
    )
    for number, wish in enumerate(wishes_to_try(stage)):
        told = WhatIf(id=number, client="", wish=wish, surroundings=pickle.dumps(about))
        price(told, stage)


def price(asked: WhatIf, stage: Stage) -> Price:
    """What the wish would cost now.

    Args:
        asked: the wish, and what is about.
        stage: map, chair and planner.
    """
    about: Surroundings = pickle.loads(asked.surroundings)  # of our own process
    planner = stage.navigator.global_planner
    problem = RouteProblem(
        grid=stage.grid,
        robot=stage.robot,
        start=about.pose[:2],
        goal=about.goal,
        wishes=about.wishes,
        wished_from=about.wished_from,
        live=about.live,
        crowding=about.crowding,
        filters=stage.navigator.filters,
        clearance=about.clearance,
    )
    wished = replace(problem, wishes=(*about.wishes, asked.wish), wished_from=about.pose[:2])
    try:
        path = planner.plan(wished)
    except PlanningError as trouble:
        return Price(id=asked.id, client=asked.client, trouble=reason_of(trouble).sentence)
    now = _planned(planner, problem)
    return Price(
        id=asked.id,
        client=asked.client,
        points=way_of(path).points,
        length=round(path.length, 2),
        extra=round(path.length - now.length, 2) if now is not None else 0.0,
    )


def _planned(planner: GlobalPlanner, problem: RouteProblem) -> Path | None:
    try:
        return planner.plan(problem)
    except PlanningError:
        return None
