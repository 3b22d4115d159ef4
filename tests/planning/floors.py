"""Small floors and problems on them."""

import numpy as np

from cohelm.maps import FREE, OCCUPIED, OccupancyGrid
from cohelm.messages import Path, Wish, WishReport
from cohelm.planning import RouteProblem
from cohelm.robots import load_robot

CHAIR = load_robot("quantum_q6_edge")


def room(width, height, resolution=0.05, boxes=(), X_MG=(0.0, 0.0, 0.0)):
    """An empty room with walls one cell thick; boxes (x0, y0, x1, y1) stand in it, m."""
    data = np.full((round(height / resolution), round(width / resolution)), FREE)
    data[[0, -1], :] = data[:, [0, -1]] = OCCUPIED
    for box in boxes:
        c0, r0, c1, r1 = (round(side / resolution) for side in box)
        data[r0:r1, c0:c1] = OCCUPIED
    return OccupancyGrid(data=data, resolution=resolution, X_MG=np.array(X_MG))


def problem(grid, start, goal, *, prefer=(), **more):
    wishes = tuple(Wish(points=np.array([point])) for point in prefer)
    given = {"robot": CHAIR, "clearance": 0.05, **more}
    return RouteProblem(
        grid=grid, start=np.array(start), goal=np.array(goal), wishes=wishes, **given
    )


def path_of(points):
    """A path along given points."""
    points = np.asarray(points, dtype=float)
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    return Path(
        points=points,
        length=length,
        cost=length,
        method="drawn",
        wishes=WishReport(closest=np.empty(0)),
        without_wishes=points,
    )
