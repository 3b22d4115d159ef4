"""Crossings of a filmed crowd, perpendicular to its main flow.

A sighting is drawn, and the chair crosses the main flow through it in a random direction, timed to
be there at the same moment if nothing slows it down.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.errors import RecordingError
from cohelm.evaluation.perception.filmed_crowd import chair_line
from cohelm.recordings import Trajectories
from cohelm.recordings.pedestrians.trajectories import LONGEST_GAP
from cohelm.scenarios.crowd import CHAIR_SPEED
from cohelm.simulation import generator

ALONG = (20.0, 80.0)
"""Percentiles of the sightings along the main flow that bound the meeting point."""
ACROSS = (1.0, 99.0)
"""Percentiles across it, near the line, beyond which start and goal lie."""
NEAR = 2.0
"""Distance from the line in which sightings count, and no person appears or vanishes, m."""
ASIDE = 1.5
"""Distance of start and goal from the flow, m; no person is closer to the start at first."""
SHORTEST = 8.0
"""Shortest distance from start to goal, m."""
DURATION = 45.0
"""Time in which no person appears or vanishes near the line, s."""
TRIES = 2000


@value
class Crossing:
    """One crossing, in the frame of the film."""

    begin: float
    """Time of the film at which the ride begins, s."""
    start: Annotated[Floats, Shape("3")]
    """(x, y, heading): facing the goal."""
    goal: Annotated[Floats, Shape("2")]
    meets: int
    """Id of the person at the meeting point."""


def crossing(film: Trajectories, seed: int) -> Crossing:
    """Draw a crossing from a seed.

    Raises:
        RecordingError: if the film has none.
    """
    rng = generator(seed, "crossing")
    axis = chair_line(film, drive=False).axis
    flow = np.array([math.cos(axis), math.sin(axis)])
    side = np.array([-flow[1], flow[0]])
    along = film.position @ flow
    low, high = np.percentile(along, ALONG)
    candidates = np.flatnonzero((along > low) & (along < high))
    edges = _edges(film)
    for k in rng.choice(candidates, TRIES) if len(candidates) else ():
        direction = float(rng.choice([-1.0, 1.0])) * side
        beside = (film.position[np.abs(along - along[k]) < NEAR] - film.position[k]) @ direction
        before, beyond = np.percentile(beside, ACROSS) + np.array([-ASIDE, ASIDE])
        start, goal = film.position[k] + before * direction, film.position[k] + beyond * direction
        begin = float(film.time[k]) + before / CHAIR_SPEED
        if beyond - before >= SHORTEST and _is_fair(film, edges, begin, start, goal):
            heading = math.atan2(direction[1], direction[0])
            return Crossing(
                begin=begin,
                start=np.array([*start, heading]),
                goal=goal,
                meets=int(film.id[np.searchsorted(film.first, k, side="right") - 1]),
            )
    raise RecordingError("has no time at which its flow can be crossed", file=film.name)


def _is_fair(film: Trajectories, edges: Floats, begin: float, start: Floats, goal: Floats) -> bool:
    """Check that the film is long enough, no person is at the start, and none appears nearby.

    ``edges`` are (time, x, y) of appearing and vanishing.
    """
    if begin < 0.0 or begin + DURATION > film.time.max():
        return False
    _, there, _ = film.at(begin)
    if (np.hypot(*(there - start).T) < ASIDE).any():
        return False
    during = (edges[:, 0] >= begin) & (edges[:, 0] <= begin + DURATION)
    near: Booleans = _off(edges[during, 1:], start, goal) < NEAR
    return not near.any()


def _off(points: Floats, start: Floats, goal: Floats) -> Floats:
    """Distance (k,) of points (k, 2) from the segment, m."""
    direction = goal - start
    share = np.clip((points - start) @ direction / (direction @ direction), 0.0, 1.0)
    apart = points - start - share[:, None] * direction
    return np.hypot(apart[:, 0], apart[:, 1])


def _edges(film: Trajectories) -> Floats:
    """(time, x, y) at which people appear or vanish, also within a film, (m, 3)."""
    last = film.first[1:] - 1
    same = np.ones(len(film.time), dtype=bool)
    same[last] = False
    gap = np.append(np.diff(film.time), 0.0) > (LONGEST_GAP + 0.5) * film.step
    broken = np.flatnonzero(same & gap)
    at = np.concatenate([film.first[:-1], last, broken, broken + 1])
    return np.column_stack([film.time[at], film.position[at]])
