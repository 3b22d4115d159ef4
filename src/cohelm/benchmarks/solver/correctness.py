"""Reliability of the solver: optima and first commands beside IPOPT's, failures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from cohelm.benchmarks.solver.comparison import OptimumVerdict, compare, first_command
from cohelm.benchmarks.solver.states import solved_ride
from cohelm.control import SsMpcDcbf
from cohelm.control.trajectories import limited_trajectory
from cohelm.errors import ControlError
from cohelm.messages import Status
from cohelm.testing.problems import random_problem

HORIZON = 25
"""N of all problems."""
CROWDS = (0, 1, 2, 5, 10, 15, 20)
"""Numbers of people of random problems, in turn."""
NEAR = np.array([0.02, 0.05])
"""First commands that differ by less, m/s and rad/s, count as equal."""
KINDS = ("random", "crowded", "hopeless")
"""States on which no solve may fail. In hopeless ones people and walls overlap the chair, and it is
faster than its limits."""

_SEEDS = 3


def optima(count: int, seed: int, planner: SsMpcDcbf | None = None) -> dict[str, Any]:
    """Compare optima: IPOPT's continued by our solver, and our own from a neutral start."""
    planner, rng = planner or SsMpcDcbf(), np.random.default_rng((seed, 200))
    found = [
        compare(random_problem(rng, people, steps=HORIZON, step=planner.step), planner)
        for people in np.resize(CROWDS, count).tolist()
    ]
    verdicts = Counter(c.verdict for c in found)
    solved = [c for c in found if c.verdict is not OptimumVerdict.UNSOLVED]
    exact = [c for c in solved if c.exact]
    kept = [(c.oracle - c.kept) / (c.oracle + 1e-3) for c in exact]
    account = [abs(c.there - c.oracle) / (c.oracle + 1e-3) for c in exact]
    return {
        "part": "optima",
        "problems": len(found),
        "solved": len(solved),
        "exact": len(exact),
        "most_gained": max([0.0, *kept]),
        "most_by_account": max([0.0, *account]),
        "stays": sum(each <= 1e-3 for each in kept),
        **{verdict.value: verdicts[verdict] for verdict in OptimumVerdict},
    }


def commands(
    people: int, rides: int, every: int, seed: int, planner: SsMpcDcbf | None = None
) -> Iterator[dict[str, Any]]:
    """Compare first commands along rides: one row per state."""
    planner, rng = planner or SsMpcDcbf(), np.random.default_rng((seed, 300, people))
    for _ in range(rides):
        drawn = random_problem(rng, people, steps=HORIZON, step=planner.step)
        for state in islice(solved_ride(planner, drawn), every, None, every):
            c = first_command(state.problem, planner.control, state.half_planes, state.seed)
            own, theirs = abs(c.budget - c.converged), abs(c.budget - c.oracle)
            yield {
                "part": "commands",
                "people": people,
                "verdict": c.verdict.value,
                "off_v": own[0],
                "off_w": own[1],
                "near_converged": bool((own <= NEAR).all()),
                "near_oracle": bool((theirs <= NEAR).all()),
            }


def failures(kind: str, solves: int, seed: int, planner: SsMpcDcbf | None = None) -> dict[str, Any]:
    """Count failed solves from random starts and failed plans: they raise or are not finite."""
    planner = planner or SsMpcDcbf()
    rng = np.random.default_rng((seed, 400, KINDS.index(kind)))
    count, done = Counter[str](), 0
    for _ in range(-(-solves // _SEEDS)):
        people = int(rng.integers(25, 51) if kind == "crowded" else rng.integers(0, 21))
        problem = random_problem(
            rng, people, steps=planner.steps, step=planner.step, hopeless=kind == "hopeless"
        ).problem
        near, current_input = (
            problem.truncated(HORIZON),
            problem.robot.motion_model.input(problem.twist),
        )
        for _ in range(_SEEDS):
            turns = np.cumsum(rng.normal(0.0, 0.3, HORIZON))
            inputs = np.column_stack([rng.uniform(-0.2, 1.0, HORIZON), turns])
            done += 1
            try:
                found = planner.control.solve(
                    near,
                    limited_trajectory(near, inputs, current_input),
                    iterations=planner.parameters.iterations,
                )
                count["failed"] += not np.isfinite(found.trajectory.poses).all()
            except ControlError:
                count["failed"] += 1
        try:
            plan = planner.plan(problem, None)
            count["plans_failed"] += not np.isfinite(plan.command).all()
            count[plan.status.value] += 1
        except ControlError:
            count["plans_failed"] += 1
    words = ("failed", "plans_failed", *(status.value for status in Status))
    return {
        "part": "failures",
        "kind": kind,
        "solves": done,
        "plans": -(-solves // _SEEDS),
        **{word: count[word] for word in words},
    }
