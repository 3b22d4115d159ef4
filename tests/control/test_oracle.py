"""Our solver against IPOPT on the same problem, written down a second time.

The whole comparison, with its figures, is printed by ``benchmarks/solver.py``.
"""

from collections import Counter

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.testing.comparison import Verdict, compare
from cohelm.testing.oracle import solve
from cohelm.testing.problems import random_problem

pytest.importorskip("casadi", reason="the oracle needs CasADi: pip install cohelm[bench]")


def compared(count, crowds):
    """Comparisons of problems that IPOPT solves, with as many people as ``crowds`` says in turn."""
    rng, planner = np.random.default_rng(5), SsMpcDcbf()
    found = []
    while len(found) < count:
        drawn = random_problem(rng, crowds[len(found) % len(crowds)])
        comparison = compare(drawn, planner)
        if comparison.verdict is not Verdict.UNSOLVED:
            found.append(comparison)
    return found


def check(found):
    exact = [c for c in found if c.exact]
    assert len(exact) > 0.8 * len(found)
    for c in exact:
        # the same cost by both accounts, but for the 1e-8 by which IPOPT lets bounds yield
        assert c.there == pytest.approx(c.oracle, rel=1e-4, abs=1e-4)
        # and an optimum for us as well
        assert c.kept >= 0.999 * c.oracle - 1e-4
    count = Counter(c.verdict for c in found)
    assert count[Verdict.SAME] + count[Verdict.BETTER] > 0.8 * len(found), count


def test_twenty_problems_have_the_optima_that_ipopt_finds():
    check(compared(20, (0, 1, 3)))


@pytest.mark.slow
def test_two_hundred_problems_have_the_optima_that_ipopt_finds():
    check(compared(200, (0, 1, 2, 5, 10, 20)))


def test_the_oracle_keeps_the_limits_and_the_law_of_motion():
    drawn = random_problem(np.random.default_rng(2), 1)
    problem, planner = drawn.problem, SsMpcDcbf()
    found, p = solve(problem, planner.control, drawn.half_planes), planner.parameters
    assert found.solved
    rolled = problem.robot.motion.rollout(problem.pose, found.inputs, p.step)
    assert np.abs(rolled - found.poses).max() < 1e-6
    low, high, rise, fall = problem.input_bounds()
    change = np.diff(np.vstack([problem.twist[[0, 2]], found.inputs]), axis=0)
    duration = np.array([p.input_limits.tick, *[p.step] * (p.steps - 1)])[:, None]
    assert (found.inputs >= low - 1e-6).all()
    assert (found.inputs <= high + 1e-6).all()
    assert (change <= rise * duration + 1e-6).all()
    assert (change >= -fall * duration - 1e-6).all()
