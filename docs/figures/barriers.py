"""Draw a plan among people with its barriers along it: the picture of docs/local-planning.md.

python docs/figures/barriers.py [--plot FILE]
"""

import argparse
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from barrier_pictures import Barrier, draw_barriers
from cohelm.arrays import Floats
from cohelm.control import LocalProblem, OptimalControl, SsMpcDcbf
from cohelm.control.objective import advanced, body_value, first_stage, social_value
from cohelm.control.optimal_control import PreparedControl
from cohelm.control.terms.barrier import REACH
from cohelm.control.terms.encounter import state_encounter
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


def values(prepared: PreparedControl, inputs: Floats) -> Floats:
    """H of body and social space of each person along inputs (N, m), (n, 2, N+1), m."""
    out = np.empty((len(prepared.scene.people.weight), 2, len(inputs) + 1))
    _fill(prepared.scene, inputs, out)
    return np.minimum(out, REACH)


@njit
def _fill(scene: Any, inputs: Floats, out: Floats) -> None:
    stage = first_stage(scene)
    for k in range(len(inputs) + 1):
        for q in range(len(out)):
            state = scene.people.states[q, k]
            e = state_encounter(scene.people, scene.robot.capsule, q, stage)
            out[q, 0, k] = body_value(scene, e, state, q, k, 2)
            out[q, 1, k] = social_value(scene.people, e, state)
        if k < len(inputs):
            stage = advanced(scene, stage, inputs[k])


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--plot", type=Path, default=Path("docs/images/barriers.png"))
    chosen = options.parse_args()
    planner = SsMpcDcbf()
    problem, plan = scene(planner), None
    for _ in range(ROUNDS):
        plan = planner.plan(problem, plan)
    terms, last = planner.parameters.terms, len(plan.inputs)
    now = problem.robot.motion_model.input(problem.twist)
    prepared = OptimalControl(terms, planner.clearance).prepare(problem, now, planned=last)
    h = values(prepared, plan.inputs)
    barriers = [
        Barrier("body of the oncoming person", h[0, 0], terms.bodies.gamma),
        Barrier("space of the oncoming person", h[0, 1], terms.social_space.gamma),
        Barrier("space of the first who talks", h[1, 1], terms.social_space.gamma),
    ]
    for each in barriers:
        print(f"{each.name:30} minimum h {each.h.min():.3f} m")
    print("costs, s:", {name: round(cost, 3) for name, cost in plan.costs.items() if cost > 0.0})
    shown = np.linspace(0, last, 5).astype(int).tolist()
    draw_barriers(problem.truncated(last), plan, barriers, chosen.plot, shown=shown)


if __name__ == "__main__":
    main()
