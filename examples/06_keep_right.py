"""Keep right in a corridor, by a cost term of your own.

A term is one residual function, compiled by ``@residual``, and the numbers that it needs. Sampling,
optimisation and choice of the planner obey it, and the plan reports its cost. Two rides in a
corridor 3 m wide, without and with the term, are drawn as seen from above.
"""

import dataclasses
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.control import LocalProblem, SsMpcDcbf
from cohelm.control.terms import residual
from cohelm.control.terms.extra import D
from cohelm.testing.scenes import local_problem, room, walls_of

WIDTH, LENGTH, TICK = 3.0, 16.0, 0.05
START = np.array([2.0, WIDTH / 2, 0.0])


@residual
def right_of_path(p: Any, z: Any) -> Any:
    """Weighted distance from a line beside the path; its square is the cost per second."""
    return p[0] * (z[D] + p[1])


class KeepRight:
    """The chair prefers to drive ``offset`` m to the right of its path."""

    name = "keep_right"
    residual = right_of_path

    def __init__(self, weight: float = 1.0, offset: float = 0.5) -> None:
        self.numbers = np.array([np.sqrt(weight), offset])

    def table(self, problem: LocalProblem) -> Floats:
        """Square root of the weight, 1/m, and offset, m."""
        return self.numbers


def drive(planner: SsMpcDcbf, seconds: float = 10.0) -> tuple[Floats, float]:
    """(poses (k, 3) along the middle of the corridor, cost of the term in the last plan, s)."""
    walls, pose, twist = walls_of(room(LENGTH, WIDTH)), START.copy(), np.zeros(3)
    plan, poses, cost = None, [pose], 0.0
    for k in range(round(seconds / TICK)):
        problem = local_problem(
            steps=planner.steps,
            step=planner.step,
            walls=walls,
            pose=(pose[0], WIDTH / 2, 0.0),
            wanted=0.7,
        )
        problem = dataclasses.replace(problem, time=k * TICK, pose=pose, twist=twist)
        plan = planner.plan(problem, plan)
        twist = plan.command
        inputs = problem.robot.motion_model.input(twist)[None]
        pose = problem.robot.motion_model.rollout(pose, inputs, TICK)[-1]
        poses.append(pose)
        cost = plan.costs.get(KeepRight.name, 0.0)
    return np.array(poses), cost


def draw(poses: Floats) -> None:
    """Print the ride from above: 2 characters a metre along, 4 lines a metre across."""
    picture = [[" "] * round(2 * LENGTH) for _ in range(round(4 * WIDTH))]
    for x, y, _ in poses:
        picture[round(4 * (WIDTH - y) - 0.5)][round(2 * x)] = "o"
    border = "=" * round(2 * LENGTH)
    print("\n".join([border, *("".join(line).rstrip() for line in picture), border]))


def main() -> None:
    for name, terms in (("without the term", []), ("keeping right", [KeepRight()])):
        poses, cost = drive(SsMpcDcbf(extra_terms=terms))
        beside = WIDTH / 2 - poses[:, 1]
        print(
            f"{name:16}: {poses[-1, 0] - poses[0, 0]:.1f} m, on average {beside.mean():+.2f} m to "
            f"the right of the path; the term costs {cost:.2f} s at last"
        )
        draw(poses)


if __name__ == "__main__":
    main()
