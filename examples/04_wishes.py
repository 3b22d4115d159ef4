"""Go this way: points, lines and zones, what they cost, and what else could be taken.

On one floor: the same wish heeded by every global planner, a zone to keep out of, a drawn line, and
routes that really differ.
"""

import numpy as np

from cohelm.maps import FREE, OCCUPIED, OccupancyGrid
from cohelm.messages import Path, Wish
from cohelm.planning import RouteProblem
from cohelm.planning.alternatives.alternatives import find_alternatives
from cohelm.plugins import build
from cohelm.robots import load_robot

START, GOAL = [2.0, 4.8], [14.0, 4.8]
METHODS = ("astar", "iterative_astar", "upf", "upf_soft", "soft_via")


def floor() -> OccupancyGrid:
    """A hall of 16 × 10 m with a block of 4 × 3 m in the middle."""
    data = np.full((200, 320), FREE, dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = OCCUPIED
    data[70:130, 120:200] = OCCUPIED
    return OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))


def problem(*wishes: Wish) -> RouteProblem:
    robot = load_robot("quantum_q6_edge")
    return RouteProblem(grid=floor(), robot=robot, start=START, goal=GOAL, wishes=wishes)


def say(name: str, path: Path) -> None:
    wishes = path.wishes
    distances = np.concatenate([wishes.closest, wishes.along, wishes.avoided])
    print(
        f"{name:16} {path.length:5.2f} m, {wishes.extra_length + 0.0:+5.2f} m for the wish, "
        f"from it {', '.join(f'{each:.2f}' for each in distances)} m"
    )


def main() -> None:
    above = Wish(points=[[8.0, 8.3]])
    for method in METHODS:
        say(method, build("global_planners", method).plan(problem(above)))

    planner = build("global_planners", "soft_via")
    spill = Wish(kind="avoid", points=[[8.0, 2.6]], radius=0.7, hard=True)
    say("not through", planner.plan(problem(spill)))
    line = Wish(kind="stroke", points=[[3.0, 6.5], [6.0, 8.0], [10.0, 8.0], [13.0, 6.5]])
    say("along a line", planner.plan(problem(line)))

    print("routes to choose from:")
    for each in find_alternatives(problem(above), planner, 2):
        features = each.features
        print(
            f"  {features.length:.1f} m, {features.time:.0f} s, {features.clearance:.1f} m of room"
        )


if __name__ == "__main__":
    main()
