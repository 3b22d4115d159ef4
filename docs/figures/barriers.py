"""Draw a plan among people with its barriers along it: the picture of docs/local-planning.md.

python docs/figures/barriers.py [--plot FILE]
"""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from barrier_pictures import Barrier, draw_barriers
from cohelm.control import LocalProblem, SsMpcDcbf, Trajectory
from cohelm.control.terms import GroupBarrier, PersonBarrier, SocialSpaceBarrier
from cohelm.messages import Groups, RiderProfile
from cohelm.social import PersonalSpace
from cohelm.testing.scenes import local_problem, walkers

WALKER = [5.2, 0.15, -0.9, 0.0]
TALKING = [[3.4, -2.3, 0.0, 0.0], [4.8, -2.3, 0.0, 0.0]]
ROUNDS = 8
"""Number of plans from the same pose, each from the previous one, so that they converge."""


def scene(planner: SsMpcDcbf) -> LocalProblem:
    """Build the problem: a chair at 1 m/s, an oncoming person, and two who talk on its right."""
    people = walkers([WALKER, *TALKING])
    problem = local_problem(
        steps=planner.steps, step=planner.step, people=people, speed=1.0, wanted=1.0
    )
    spaces = PersonalSpace().spaces(
        people,
        Groups(id=[1], member=[-1, 0, 0]),
        problem.predictions,
        problem.twist,
        RiderProfile(),
    )
    return dataclasses.replace(problem, spaces=spaces)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--plot", type=Path, default=Path("docs/images/barriers.png"))
    chosen = options.parse_args()
    planner = SsMpcDcbf()
    problem, plan = scene(planner), None
    for _ in range(ROUNDS):
        plan = planner.plan(problem, plan)
    near = problem.truncated(len(plan.inputs))
    trajectory = Trajectory(
        step=plan.step,
        poses=plan.poses,
        inputs=plan.inputs,
        current_input=problem.robot.motion_model.input(problem.twist),
    )
    barriers = []
    for name, law in (
        ("body of the oncoming person", PersonBarrier(planner.parameters.bodies)),
        ("space of the oncoming person", SocialSpaceBarrier(planner.parameters.social_space)),
        ("space of the group", GroupBarrier(planner.parameters.group_space)),
    ):
        found = law.values(near, trajectory)
        barriers.append(Barrier(name, found.h[0], law.parameters.gamma))
        print(f"{name:30} slack {found.slack.max():.3f} m, minimum h {found.h[0].min():.3f} m")
    last = len(plan.inputs)
    shown = np.linspace(0, last, 5).astype(int).tolist()
    draw_barriers(near, plan, barriers, chosen.plot, shown=shown)


if __name__ == "__main__":
    main()
