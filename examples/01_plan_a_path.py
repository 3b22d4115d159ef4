"""Plan a route on a map of one's own, and see what a wish costs.

Draws a small floor, writes it as any Nav2 map server would read it, reads it again, and plans
across it twice: the shortest way, and one that passes by a place the rider likes.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cohelm.maps import FREE, OCCUPIED, OccupancyGrid, read_map, write_map
from cohelm.messages import Wish
from cohelm.planning import RouteProblem
from cohelm.plugins import build
from cohelm.robots import load_robot


def floor() -> OccupancyGrid:
    """A hall of 16 × 10 m with a block of 4 × 3 m in the middle."""
    data = np.full((200, 320), FREE, dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = OCCUPIED
    data[70:130, 120:200] = OCCUPIED
    return OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))


def main() -> None:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "hall.yaml"
        write_map(floor(), file)
        grid = read_map(file)
    robot = load_robot("quantum_q6_edge")
    start, goal = np.array([2.0, 4.8]), np.array([14.0, 4.8])
    by_the_window = Wish(points=np.array([[8.0, 8.5]]))

    plain = build("global_planners", "astar").plan(
        RouteProblem(grid=grid, robot=robot, start=start, goal=goal)
    )
    wished = build("global_planners", "upf").plan(
        RouteProblem(grid=grid, robot=robot, start=start, goal=goal, wishes=(by_the_window,))
    )
    print(f"shortest       {plain.length:6.2f} m")
    print(
        f"by the window  {wished.length:6.2f} m, passes at {wished.wishes.closest[0]:.2f} m, "
        f"costs {wished.wishes.extra_length:+.2f} m"
    )


if __name__ == "__main__":
    main()
