"""How far the chair may go back: as far as is known to be free, and nobody comes there.

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
    bend: float = 0.0
    """Of the way back that this was seen of, rad/m."""


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
    return Behind(trail=trail, room=memory.room, room_at=memory.room_at, bend=memory.bend)


def room_behind(  # noqa: PLR0913  # keyword-only, one meaning each
    memory: Behind,
    robot: Robot,
    pose: Floats,
    time: float,
    *,
    bend: float,
    detections: tuple[Detections, ...],
    walls: DistanceField,
    people: People,
    most: float,
) -> tuple[float, Behind]:
    """How far the chair may go back, at most ``most``, m, and what to remember.

    Args:
        memory: of the last call.
        robot: whose footprint goes back.
        pose: X_MR, (3,).
        time: now, s.
        bend: by how much it turns as it goes back, rad/m.
        detections: of each scan that came since the last call.
        walls: distance to all that is not a person.
        people: nobody may be in the way.
        most: how far is asked, m.
    """
    if _somebody(robot, pose, people, most):
        return 0.0, memory
    known = memory
    scans = any(seen.heights is None for seen in detections)
    seen = memory.room
    if scans or bend != memory.bend or not is_held(memory, time):
        places = _places(robot, pose, bend, most)
        at = places.reshape(-1, 2)
        free = _been_there(robot, at, memory.trail)  # all there is without a planar scanner
        if scans:
            free |= _seen_through(detections, at)
        seen = _rows(free.reshape(places.shape[:2]))
        known = Behind(trail=memory.trail, room=seen, room_at=time, bend=bend)
    return min(most, seen, _past_walls(robot, pose, bend, walls, most)), known


def is_held(memory: Behind, time: float) -> bool:
    """Whether what was seen of the way back still counts."""
    return time - memory.room_at <= _HELD


def way_back(pose: Floats, bend: float, gone: Floats) -> Floats:
    """Poses (k, 3) of a chair that has gone back from ``pose`` (3,) by ``gone`` (k,), m.

    ``bend`` is by how much it turns on each metre, rad.
    """
    half = 0.5 * bend * gone
    chord = gone * np.sinc(half / np.pi)
    return np.stack(
        [
            pose[0] - chord * np.cos(pose[2] + half),
            pose[1] - chord * np.sin(pose[2] + half),
            pose[2] + 2.0 * half,
        ],
        axis=-1,
    )


def _places(robot: Robot, pose: Floats, bend: float, most: float) -> Floats:
    """Rows of places (rows, places, 2) on the map that the chair's rear comes to, m."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    count = int(np.ceil((high[1] - low[1]) / _ROW)) + 1
    rear = np.column_stack([np.full(count, low[0]), np.linspace(low[1], high[1], count)])
    gone = np.asarray(_ROW * (np.arange(round(most / _ROW) + 1) + 0.5), dtype=np.float64)
    return np.stack([transform(then, rear) for then in way_back(pose, bend, gone)])


def _rows(free: Booleans) -> float:
    """How far it is free, one row of it kept as a margin, m."""
    whole = np.asarray(free.all(axis=1), dtype=bool)
    rows = len(whole) if whole.all() else int(np.argmin(whole))
    return max(rows - 1, 0) * _ROW


def _seen_through(detections: tuple[Detections, ...], places: Floats) -> Booleans:
    """Through which places (n, 2) of the map the beams of a planar scanner went just now.

    At least two beams go there, and every one of them goes on.
    """
    out = np.zeros(len(places), dtype=bool)
    for seen in detections:
        if seen.heights is not None:
            continue
        ends = np.concatenate([seen.points, seen.through]) - seen.origin
        length = np.hypot(*ends.T)
        to = places - seen.origin
        away = np.maximum(np.hypot(*to.T), 1e-6)
        unit = to / away[:, None]
        aside = np.abs(unit[:, :1] * ends[:, 1] - unit[:, 1:] * ends[:, 0])
        asked = aside <= (0.5 * _REACH / away)[:, None] * length
        asked &= unit @ ends.T > 0.0
        stopped = asked & (length < (away + _REACH)[:, None])
        out |= (asked.sum(axis=1) >= 2) & ~stopped.any(axis=1)
    return out


def _been_there(robot: Robot, places: Floats, trail: Floats) -> Booleans:
    """Which places (n, 2) of the map the chair's footprint has covered lately."""
    low, high = robot.outline.min(axis=0) - 1e-9, robot.outline.max(axis=0) + 1e-9
    out = np.zeros(len(places), dtype=bool)
    for then in trail[:, 1:]:
        inside = transform(inverse(then), places)
        out |= ((inside >= low) & (inside <= high)).all(axis=1)
    return out


def _past_walls(
    robot: Robot, pose: Floats, bend: float, walls: DistanceField, most: float
) -> float:
    """How far the footprint's discs can go back without touching, m."""
    back: Floats = np.arange(1.0, round(most / 0.05) + 1.0) * 0.05
    discs = robot.discs
    gaps = np.array([walls.at(transform(X, discs[:, :2])) for X in way_back(pose, bend, back)])
    gaps = gaps.reshape(len(back), -1)
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
