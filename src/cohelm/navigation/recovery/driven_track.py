"""Driven track: the last metres that the chair drove forward, and the way back along them.

The footprint has just been at every pose of the track, so the way back fits it. A person or an
object may have come there since; ``rear_clearance`` checks that.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import arc_length, inverse, transform, wrap_angle
from cohelm.messages import Path

TRACK_LENGTH = 10.0
"""Length of the track that is kept, m: a chair backs up no farther, because the rider cannot see
where it goes."""
_SPACING = 0.1
"""Distance between poses of the track, m."""
_JUMP = 0.5
"""Distance from the last pose at which the track begins again, m: the localisation jumped."""
_PIVOT = 0.6
"""Turn between two poses that ends the way back, rad: the chair turned on the spot there."""
_MERGE = 0.4
"""Distance within which the way back joins the track, m; a nearer point would need a sharp turn."""
_ON_TRACK, _ALIGNED = 0.1, 0.2
"""Offset, m, and turn, rad, from the nearest pose up to which the chair is on its track."""


def extend_track(track: Floats | None, pose: Floats) -> Floats:
    """Add ``pose`` (3,) to the track (k, 3), and remove what the chair has backed over.

    Returns ``track`` itself if nothing changes.
    """
    here = np.asarray(pose, dtype=float)[None]
    if track is None or len(track) == 0:
        return here
    distance = float(np.hypot(*(track[-1, :2] - pose[:2])))
    if distance > _JUMP:
        return here
    count = _count_behind(track, pose)
    if count < len(track):
        return track[:count] if count else here
    if distance < _SPACING:
        return track
    return np.concatenate([track, here])[-round(TRACK_LENGTH / _SPACING) :]


def way_back(track: Floats, pose: Floats, limit: float) -> Floats:
    """Poses (k, 3) from ``pose`` (3,) back along the track, with continuous headings.

    Args:
        track: (m, 3).
        pose: of the chair; the first of the result.
        limit: maximum length, m.
    """
    back = track[::-1]
    if len(back):
        distance = np.hypot(*(back[:, :2] - pose[:2]).T)
        near = int(np.argmin(distance))
        turn = abs(float(wrap_angle(back[near, 2] - pose[2])))
        on_track = distance[near] <= _ON_TRACK and turn <= _ALIGNED
        back = back[distance >= (_SPACING if on_track else _MERGE)]
    poses = np.concatenate([np.asarray(pose, dtype=float)[None], back])
    turns = np.asarray(wrap_angle(np.diff(poses[:, 2])))
    gaps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    broken = (np.abs(turns) > _PIVOT) | (gaps > max(_JUMP, _MERGE + 2.0 * _SPACING))
    count = 1 + (int(np.argmax(broken)) if broken.any() else len(turns))
    headings = pose[2] + np.concatenate([[0.0], np.cumsum(turns)])
    poses = np.column_stack([poses[:, :2], headings])[:count]
    return poses[arc_length(poses[:, :2]) <= limit]


def poses_backward(path: Path, pose: Floats, progress: float) -> Floats:
    """Poses (k, 3) of a chair that drives the rest of a path backwards, with continuous headings.

    Args:
        path: driven backwards from its beginning to its end.
        pose: of the chair; the first of the result.
        progress: arc length of the chair on the path, m.
    """
    along = arc_length(path.points)
    ahead = path.points[along > progress + _SPACING]
    points = np.concatenate([pose[None, :2], ahead if len(ahead) else path.points[-1:]])
    steps = np.diff(points, axis=0)
    headings = np.arctan2(-steps[:, 1], -steps[:, 0])
    turns = np.asarray(wrap_angle(np.diff(np.concatenate([pose[2:], headings]))))
    return np.column_stack([points, pose[2] + np.concatenate([[0.0], np.cumsum(turns)])])


def poses_along(poses: Floats, travelled: Floats) -> Floats:
    """Poses (n, 3) at the distances ``travelled`` (n,) along ``poses`` (k, 3), m.

    The last pose holds beyond the end.
    """
    along = arc_length(poses[:, :2])
    return np.stack([np.interp(travelled, along, poses[:, i]) for i in range(3)], axis=-1)


def _count_behind(track: Floats, pose: Floats) -> int:
    """Number of poses (k, 3) up to the last one that is not ahead of the chair."""
    ahead = transform(inverse(pose), track[:, :2])[:, 0] > 0.5 * _SPACING
    count = len(track)
    while count > 0 and ahead[count - 1]:
        count -= 1
    return count
