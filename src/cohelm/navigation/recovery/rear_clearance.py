"""Rear clearance: distance that the chair may back up.

Sensors may not look backwards. A place behind the chair is known to be free if beams of a planar
scanner have just passed through it, or if the chair itself was there within the last seconds. Beams
of a point cloud prove nothing, because they may pass above something low.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import inverse, transform
from cohelm.maps import DistanceField
from cohelm.messages import Observation, People
from cohelm.perception import Detections
from cohelm.robots import Robot

_ROW = 0.1
"""Spacing of the places that are checked, m."""
_WIDTH = 0.08
"""Width of each of them, m."""
_TRAIL_SPACING = 0.1
"""Distance between entries of the trail, m."""
_WALL_STEP = 0.05
"""Spacing of the poses that are checked against walls, m."""
_WALL_MARGIN = 0.03
"""Gap to a wall that counts as contact, m."""
_AT_WALL = 0.07
"""Distance from a known wall up to which a return is one of the wall, m: less than the thickness of
a leg that touches it."""
_PEOPLE_BEHIND = 1.0
"""No person may be, or come within a second, this near behind the backed-up chair, m …"""
_PEOPLE_BESIDE = 0.5
"""… and this near beside it, m."""
_STANDING_BEHIND, _STANDING_BESIDE = 0.5, 0.2
"""The same for people who stand, m: in a jam people wait near the chair."""
_STANDS = 0.15
"""Speed below which a person stands, m/s."""
_RECENT = 0.3
"""Validity of an observation, s: scans are less frequent than ticks."""
ALONG_TRACK = np.inf
"""Curvature of ``RearMemory`` for a way back along the driven track."""

WayBack = Callable[[Floats], Floats]
"""Poses (k, 3) of the chair at the distances (k,) backwards, m."""


@value
class RearMemory:
    """Knowledge of the space behind the chair."""

    trail: Annotated[Floats, Shape("k 4")]
    """(time, x, y, heading) of the chair's recent poses, in s, m and rad."""
    clearance: float = 0.0
    """Distance observed to be free when a scan last came, m."""
    observed_at: float = -np.inf
    """Time of that observation, s."""
    curvature: float = 0.0
    """Curvature for which it was observed, rad/m."""


class RearScene(NamedTuple):
    """Obstacles and people about the chair."""

    detections: tuple[Detections, ...]
    """One for each scan since the last call."""
    walls: DistanceField
    people: People


def extend_trail(
    memory: RearMemory | None, pose: Floats, time: float, duration: float
) -> RearMemory:
    """Add ``pose`` (3,) to the trail, and remove entries older than ``duration``, s."""
    here = np.array([[time, *pose]])
    if memory is None:
        return RearMemory(trail=here)
    old = memory.trail
    kept = old[(old[:, 0] >= time - duration) & (old[:, 0] <= time)]
    moved = len(kept) == 0 or bool(np.hypot(*(kept[-1, 1:3] - pose[:2])) >= _TRAIL_SPACING)
    if not moved and len(kept) == len(old):
        return memory
    return RearMemory(
        trail=np.concatenate([kept, here]) if moved else kept,
        clearance=memory.clearance,
        observed_at=memory.observed_at,
        curvature=memory.curvature,
    )


def rear_clearance(
    memory: RearMemory,
    robot: Robot,
    observation: Observation,
    scene: RearScene,
    *,
    curvature: float,
    limit: float,
    way_back: WayBack | None = None,
) -> tuple[float, RearMemory]:
    """Compute the distance that the chair may back up, m, and update the memory.

    Args:
        memory: of the last call.
        robot: its footprint.
        observation: pose and time.
        scene: detections, walls and people.
        curvature: of backing up, rad/m; ``ALONG_TRACK`` with a ``way_back``.
        limit: upper bound of the result, m.
        way_back: poses to back up through; None: an arc of that curvature.
    """
    pose, time = observation.pose, observation.time
    back = way_back or (lambda travelled: reverse_poses(pose, curvature, travelled))
    if _person_behind(robot, pose, scene.people, limit):
        return 0.0, memory
    updated, observed = memory, memory.clearance
    scanned = any(each.heights is None for each in scene.detections)
    if scanned or curvature != memory.curvature or not is_recent(memory, time):
        places = _swept_places(robot, back, limit)
        points = places.reshape(-1, 2)
        # Without a planar scanner the trail is the only evidence.
        free = _on_trail(robot, points, memory.trail)
        if scanned:
            free |= _passed_by_beams(scene.detections, points, scene.walls)
        observed = _free_distance(free.reshape(places.shape[:2]))
        updated = RearMemory(
            trail=memory.trail, clearance=observed, observed_at=time, curvature=curvature
        )
    return min(limit, observed, _to_walls(robot, pose, back, scene.walls, limit)), updated


def is_recent(memory: RearMemory, time: float) -> bool:
    """Check that the last observation of the space behind is still valid."""
    return time - memory.observed_at <= _RECENT


def reverse_poses(pose: Floats, curvature: float, travelled: Floats) -> Floats:
    """Poses (k, 3) of a chair that has backed up from ``pose`` (3,) by ``travelled`` (k,), m.

    ``curvature`` is the turn per metre, rad/m.
    """
    half = 0.5 * curvature * travelled
    chord = travelled * np.sinc(half / np.pi)
    return np.stack(
        [
            pose[0] - chord * np.cos(pose[2] + half),
            pose[1] - chord * np.sin(pose[2] + half),
            pose[2] + 2.0 * half,
        ],
        axis=-1,
    )


def _swept_places(robot: Robot, back: WayBack, limit: float) -> Floats:
    """Places (rows, places, 2) on the map that the rear edge sweeps, m."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    count = int(np.ceil((high[1] - low[1]) / _ROW)) + 1
    rear = np.column_stack([np.full(count, low[0]), np.linspace(low[1], high[1], count)])
    travelled = np.asarray(_ROW * (np.arange(round(limit / _ROW) + 1) + 0.5), dtype=np.float64)
    return np.stack([transform(each, rear) for each in back(travelled)])


def _free_distance(free: Booleans) -> float:
    """Distance up to the first row that is not free, less one row as a margin, m."""
    whole = np.asarray(free.all(axis=1), dtype=bool)
    rows = len(whole) if whole.all() else int(np.argmin(whole))
    return max(rows - 1, 0) * _ROW


def _passed_by_beams(
    detections: tuple[Detections, ...], places: Floats, walls: DistanceField
) -> Booleans:
    """Mask (n,) of the places (n, 2) of the map that beams of a planar scanner just passed.

    At least two beams reach the place, and none of them ends before it or in it but at a known
    wall, whose gap is checked apart: in a corridor beams end close beside the chair.
    """
    out = np.zeros(len(places), dtype=bool)
    for each in detections:
        if each.heights is not None:
            continue
        ends = np.concatenate([each.points, each.free_ends])
        unexplained = walls.at(ends) > _AT_WALL
        ends = ends - each.origin
        length = np.hypot(*ends.T)
        to = places - each.origin
        distance = np.maximum(np.hypot(*to.T), 1e-6)
        unit = to / distance[:, None]
        offset = np.abs(unit[:, :1] * ends[:, 1] - unit[:, 1:] * ends[:, 0])
        meets = offset <= (0.5 * _WIDTH / distance)[:, None] * length
        meets &= unit @ ends.T > 0.0
        stopped = meets & unexplained & (length < (distance + _WIDTH)[:, None])
        out |= (meets.sum(axis=1) >= 2) & ~stopped.any(axis=1)
    return out


def _on_trail(robot: Robot, places: Floats, trail: Floats) -> Booleans:
    """Mask (n,) of the places (n, 2) of the map that the footprint recently covered."""
    low, high = robot.outline.min(axis=0) - 1e-9, robot.outline.max(axis=0) + 1e-9
    out = np.zeros(len(places), dtype=bool)
    for pose in trail[:, 1:]:
        inside = transform(inverse(pose), places)
        out |= ((inside >= low) & (inside <= high)).all(axis=1)
    return out


def _to_walls(
    robot: Robot, pose: Floats, back: WayBack, walls: DistanceField, limit: float
) -> float:
    """Distance that the discs of the footprint can back up without contact, m."""
    travelled: Floats = np.arange(1.0, round(limit / _WALL_STEP) + 1.0) * _WALL_STEP
    discs = robot.discs
    gaps = np.array([walls.at(transform(X, discs[:, :2])) for X in back(travelled)])
    gaps = gaps.reshape(len(travelled), -1)
    # A chair close to a wall beside it may leave at the clearance that it has now.
    now = walls.at(transform(pose, discs[:, :2])) - discs[:, 2]
    fits = (gaps - discs[:, 2] >= min(_WALL_MARGIN, float(now.min()))).all(axis=1)
    return float(_WALL_STEP * (len(travelled) if fits.all() else np.argmin(fits)))


def _person_behind(robot: Robot, pose: Floats, people: People, limit: float) -> bool:
    """Check for a person behind the chair now or within a second."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    X_RM = inverse(pose)
    stands = np.hypot(*people.mean[:, 2:].T) < _STANDS
    extent = np.where(stands, _STANDING_BEHIND, _PEOPLE_BEHIND) + people.radius
    width = np.where(stands, _STANDING_BESIDE, _PEOPLE_BESIDE) + people.radius
    for after in (0.0, 0.5, 1.0):
        x, y = transform(X_RM, people.mean[:, :2] + after * people.mean[:, 2:]).T
        behind = (x < 0.5 * low[0]) & (x > low[0] - limit - extent)
        beside = (y > low[1] - width) & (y < high[1] + width)
        if (behind & beside).any():
            return True
    return False
