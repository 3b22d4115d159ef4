"""Occupied goal: a person stands where the chair would stand at its goal.

The chair waits near the goal outside the person's space, and takes the place once it is free. To
creep closer, to back up or to look for another path helps only if the person waits for the chair,
so it comes later.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length
from cohelm.messages import Path, People
from cohelm.robots import Robot
from cohelm.robots.capsule import gap_to_disc

_NEAR = 3.0
"""Remaining length at which a goal counts as occupied, m: from farther away the person may be gone
when the chair arrives."""
_GAP, _KEPT_GAP = 0.05, 0.1
"""Gap between the chair at its goal and a standing person that is too small to arrive, m: even a
creeping chair keeps more; the second while it waits."""
_SPACING = 0.1
"""Spacing of the places that are checked, m."""
_APPROACH = 0.7
"""Distance before the goal from which the chair's heading there is taken, m."""


def waiting_place(
    path: Path,
    progress: float,
    people: People,
    robot: Robot,
    *,
    distance: float,
    standing_speed: float,
    waits: bool,
) -> float | None:
    """Arc length on the path at which to wait for a person who stands at its end, m.

    Args:
        path: to the goal.
        progress: arc length of the chair on it, m.
        people: tracked people.
        robot: its footprint.
        distance: to keep from the person, m.
        standing_speed: speed below which a person stands, m/s.
        waits: the chair waits already.

    Returns:
        The arc length, at least ``progress``; None: the goal is far away or free.
    """
    if path.length - progress > _NEAR:
        return None
    standing = np.hypot(*people.mean[:, 2:].T) < standing_speed
    along = arc_length(path.points)
    end = float(along[-1])
    at_goal = _gaps(path.points, along, end, robot, people)
    occupying = standing & (at_goal < (_KEPT_GAP if waits else _GAP))
    if not occupying.any():
        return None
    for s in np.arange(end, progress, -_SPACING):
        if (_gaps(path.points, along, float(s), robot, people)[occupying] >= distance).all():
            return float(s)
    return progress


def _gaps(points: Floats, along: Floats, s: float, robot: Robot, people: People) -> Floats:
    """Gaps (n,) between people and the chair at arc length ``s``, heading along the path, m."""
    before, here = (
        np.array([np.interp(at, along, points[:, i]) for i in (0, 1)]) for at in (s - _APPROACH, s)
    )
    direction = here - before
    pose = np.array([*here, np.arctan2(direction[1], direction[0])])
    return np.array(
        [
            gap_to_disc(robot.capsule, pose, x, y, radius)
            for (x, y), radius in zip(people.mean[:, :2], people.radius, strict=True)
        ]
    ).reshape(len(people))
