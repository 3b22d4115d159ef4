"""The outlines of groups that stand together, which a path is not to cut through."""

from __future__ import annotations

import cv2
import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import distance_to_polygon
from cohelm.messages import Groups, People

_BETWEEN = 0.1
"""A way this near to the outline leads between the members, m."""


def outlines(people: People, groups: Groups, standing: float) -> tuple[Floats, ...]:
    """The convex hull (k, 2) of the members of each group that stand, m; of two, their segment.

    Who walks takes their group along and is no part of it; one alone has no between.

    Args:
        people: who is there.
        groups: who belongs together.
        standing: people slower than this stand, m/s.
    """
    stands = np.hypot(*people.mean[:, 2:].T) < standing
    members = (people.mean[stands & (groups.member == k), :2] for k in range(len(groups.id)))
    return tuple(_hull(points) for points in members if len(points) > 1)


def cuts(points: Floats, groups: tuple[Floats, ...]) -> int:
    """Between the members of how many groups a way leads.

    Args:
        points: of the way (k, 2), close together, m.
        groups: outlines as of :func:`outlines`.
    """
    return sum(
        any(distance_to_polygon(outline, x, y) < _BETWEEN for x, y in points.tolist())
        for outline in groups
    )


def _hull(points: Floats) -> Floats:
    """Corners (k, 2) of the convex hull of points (m, 2); the two ends where they lie in line."""
    # OpenCV computes in single precision: from the middle on that is far below a millimetre.
    middle = points.mean(axis=0)
    corners = cv2.convexHull((points - middle).astype(np.float32), returnPoints=False)
    hull: Floats = points[corners[:, 0]]
    return hull
