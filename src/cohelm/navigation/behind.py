"""How far the chair may go straight back: as far as is known to be free, and nobody comes there.

Sensors may not look backwards. A place behind the chair is known to be free where beams of a planar
scanner have just gone through it, or where the chair itself has been within the last seconds; what
a cloud's beams pass over is no such place, for they may pass above something low.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import inverse, transform
from cohelm.maps import DistanceField
from cohelm.messages import People
from cohelm.perception import Detections
from cohelm.perception.sight import SEEN_THROUGH, sight
from cohelm.robots import Robot

_ROW = 0.1
"""Between the places that are looked at, m."""
_REACH = 0.08
"""Of each of them, m."""
_APART = 0.1
"""Between the entries of the trail, m."""
_WALL_MARGIN = 0.03
"""Gap to a wall that counts as contact, m."""
_ROOM_OF_THEIR_OWN = 1.0
"""Nobody may be, or be within a second, so near behind where the chair's rear would get, m …"""
_BESIDE = 0.5
"""… and so near beside it, m."""
_HELD = 0.3
"""What was seen a moment ago still counts: scans come less often than ticks, s."""


@value
class Behind:
    """What is remembered of what lies behind."""

    trail: Annotated[Floats, Shape("k 4")]
    """(time, x, y, heading): where the chair was lately, in s, m and rad."""
    room: float = 0.0
    """Seen to be free when a scan last came, m."""
    room_at: float = -np.inf
    """When that was, s."""


def follow(memory: Behind | None, pose: Floats, time: float, recent: float) -> Behind:
    """The memory with the chair at ``pose`` (3,) now; what is older is forgotten."""
    here = np.array([[time, *pose]])
    if memory is None:
        return Behind(trail=here)
    old = memory.trail
    fresh = old[(old[:, 0] >= time - recent) & (old[:, 0] <= time)]
    moved = len(fresh) == 0 or bool(np.hypot(*(fresh[-1, 1:3] - pose[:2])) >= _APART)
    if not moved and len(fresh) == len(old):
        return memory
    trail = np.concatenate([fresh, here]) if moved else fresh
    return Behind(trail=trail, room=memory.room, room_at=memory.room_at)


def room_behind(
    memory: Behind,
    robot: Robot,
    pose: Floats,
    time: float,
    *,
    detections: tuple[Detections, ...],
    walls: DistanceField,
    people: People,
    most: float,
) -> tuple[float, Behind]:
    """How far the chair may go straight back, at most ``most``, m, and what to remember.

    Args:
        memory: of the last call.
        robot: whose footprint goes back.
        pose: X_MR, (3,).
        time: now, s.
        detections: of each scan that came since the last call.
        walls: distance to all that is not a person.
        people: nobody may be in the way.
        most: how far is asked, m.
    """
    if _somebody(robot, pose, people, most):
        return 0.0, memory
    known = memory
    if any(seen.heights is None for seen in detections):
        places = _places(robot, most)
        free = _been_there(robot, pose, places.reshape(-1, 2), memory.trail)
        free |= _seen_through(detections, transform(pose, places.reshape(-1, 2)))
        room = _rows(free.reshape(places.shape[:2]))
        known = Behind(trail=memory.trail, room=room, room_at=time)
    if time - known.room_at <= _HELD:
        seen = known.room
    else:  # no planar scanner: only where the chair has been
        places = _places(robot, most)
        been = _been_there(robot, pose, places.reshape(-1, 2), memory.trail)
        seen = _rows(been.reshape(places.shape[:2]))
    return min(most, seen, _past_walls(robot, pose, walls, most)), known


def _places(robot: Robot, most: float) -> Floats:
    """Rows of places behind the chair (rows, places, 2) in its frame, m."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    count = int(np.ceil((high[1] - low[1]) / _ROW)) + 1
    x = low[0] - _ROW * (np.arange(round(most / _ROW) + 1) + 0.5)
    y = np.linspace(low[1], high[1], count)
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)


def _rows(free: Booleans) -> float:
    """How far it is free, one row of it kept as a margin, m."""
    whole = np.asarray(free.all(axis=1), dtype=bool)
    rows = len(whole) if whole.all() else int(np.argmin(whole))
    return max(rows - 1, 0) * _ROW


def _seen_through(detections: tuple[Detections, ...], places: Floats) -> Booleans:
    """Through which places (n, 2) of the map the beams of a planar scanner went just now."""
    discs = np.column_stack([places, np.full(len(places), _REACH)])
    out = np.zeros(len(places), dtype=bool)
    for seen in detections:
        if seen.heights is None:
            out |= sight(seen.origin, seen.points, seen.through, discs) == SEEN_THROUGH
    return out


def _been_there(robot: Robot, pose: Floats, places: Floats, trail: Floats) -> Booleans:
    """Which places (n, 2) of the chair's frame its footprint has covered lately."""
    low, high = robot.outline.min(axis=0) - 1e-9, robot.outline.max(axis=0) + 1e-9
    at = transform(pose, places)
    out = np.zeros(len(places), dtype=bool)
    for then in trail[:, 1:]:
        inside = transform(inverse(then), at)
        out |= ((inside >= low) & (inside <= high)).all(axis=1)
    return out


def _past_walls(robot: Robot, pose: Floats, walls: DistanceField, most: float) -> float:
    """How far the footprint's discs can go back without touching, m."""
    back = np.arange(1, round(most / 0.05) + 1) * 0.05
    discs = robot.discs
    centres = discs[None, :, :2] - np.stack([back, np.zeros_like(back)], axis=-1)[:, None]
    gaps = walls.at(transform(pose, centres.reshape(-1, 2))).reshape(len(back), -1)
    # Where the chair stands close to a wall beside it, it may leave as it came.
    now = walls.at(transform(pose, discs[:, :2])) - discs[:, 2]
    fits = (gaps - discs[:, 2] >= min(_WALL_MARGIN, float(now.min()))).all(axis=1)
    return float(0.05 * (len(back) if fits.all() else np.argmin(fits)))


def _somebody(robot: Robot, pose: Floats, people: People, most: float) -> bool:
    """Whether somebody is behind the chair, or will be within a second."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    X_RM = inverse(pose)
    for after in (0.0, 0.5, 1.0):
        x, y = transform(X_RM, people.mean[:, :2] + after * people.mean[:, 2:]).T
        reach = _ROOM_OF_THEIR_OWN + people.radius
        within = (x < 0.5 * low[0]) & (x > low[0] - most - reach)
        beside = (y > low[1] - _BESIDE - people.radius) & (y < high[1] + _BESIDE + people.radius)
        if (within & beside).any():
            return True
    return False
