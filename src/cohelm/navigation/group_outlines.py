"""Outlines of standing groups, which a path should not cross."""

from __future__ import annotations

import cv2
import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import Groups, People


def group_outlines(people: People, groups: Groups, standing_speed: float) -> tuple[Floats, ...]:
    """Convex hull (k, 2) of the standing members of each group, m; of two, their segment.

    Walking members do not count, and one standing member has no outline.

    Args:
        people: tracked people.
        groups: their membership.
        standing_speed: people slower than this stand, m/s.
    """
    if not len(groups.id):
        return ()
    stands = np.hypot(*people.mean[:, 2:].T) < standing_speed
    members = (people.mean[stands & (groups.member == k), :2] for k in range(len(groups.id)))
    return tuple(_hull(points) for points in members if len(points) > 1)


def _hull(points: Floats) -> Floats:
    """Corners (k, 2) of the convex hull of points (m, 2); of collinear points the two ends."""
    # OpenCV uses single precision: about the mean that is far below a millimetre.
    mean = points.mean(axis=0)
    corners = cv2.convexHull((points - mean).astype(np.float32), returnPoints=False)
    hull: Floats = points[corners[:, 0]]
    return hull
