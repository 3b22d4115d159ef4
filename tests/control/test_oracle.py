"""Our solver against IPOPT on the same problem, written down a second time.

The whole comparison, with its figures, is made by ``cohelm bench solver``.
"""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from cohelm.benchmarks.solver.comparison import OptimumVerdict, along, compare
from cohelm.benchmarks.solver.correctness import commands, failures
from cohelm.benchmarks.solver.oracle import solve
from cohelm.benchmarks.solver.states import with_futures
from cohelm.control import OptimalControl, SsMpcDcbf
from cohelm.control.stack import Terms, TrackingTerms
from cohelm.control.terms import InputDeviation, TrackReference
from cohelm.messages import Groups
from cohelm.robots.clearance import Clearance
from cohelm.social import PersonalSpace
from cohelm.testing.problems import field_of, random_problem
from cohelm.testing.scenes import local_problem, walkers

pytest.importorskip("casadi", reason="the oracle needs CasADi: pip install cohelm[bench]")


def compared(count, crowds):
    """Comparisons of problems that IPOPT solves, with as many people as ``crowds`` says in turn."""
    rng, planner = np.random.default_rng(5), SsMpcDcbf()
    found = []
    while len(found) < count:
        drawn = random_problem(rng, crowds[len(found) % len(crowds)])
        comparison = compare(drawn, planner)
        if comparison.verdict is not OptimumVerdict.UNSOLVED:
            found.append(comparison)
    return found


def check(found):
    exact = [c for c in found if c.exact]
    assert len(exact) > 0.5 * len(found)
    for c in exact:
        # the same cost by both accounts, but for the 1e-8 by which IPOPT lets bounds yield
        assert c.there == pytest.approx(c.oracle, rel=1e-4, abs=1e-4)
        # and an optimum for us as well
        assert c.kept >= 0.999 * c.oracle - 1e-4
    count = Counter(c.verdict for c in found)
    assert count[OptimumVerdict.SAME] + count[OptimumVerdict.BETTER] > 0.8 * len(found), count


def test_twenty_problems_have_the_optima_that_ipopt_finds():
    check(compared(20, (0, 1, 3)))


@pytest.mark.slow
def test_two_hundred_problems_have_the_optima_that_ipopt_finds():
    check(compared(200, (0, 1, 2, 5, 10, 20)))


def test_the_oracle_keeps_the_limits_and_the_law_of_motion():
    drawn = random_problem(np.random.default_rng(2), 1)
    problem, planner = drawn.problem, SsMpcDcbf()
    found, step = solve(problem, planner.control, drawn.half_planes), planner.step
    assert found.solved
    rolled = problem.robot.motion_model.rollout(problem.pose, found.inputs, step)
    assert np.abs(rolled - found.poses).max() < 1e-6
    low, high, rise, fall = problem.input_bounds()
    change = np.diff(np.vstack([problem.twist[[0, 2]], found.inputs]), axis=0)
    duration = np.array([planner.control.tick, *[step] * (len(change) - 1)])[:, None]
    assert (found.inputs >= low - 1e-6).all()
    assert (found.inputs <= high + 1e-6).all()
    assert (change <= rise * duration + 1e-6).all()
    assert (change >= -fall * duration - 1e-6).all()


def check_account(problem, control, half_planes):
    """IPOPT's solution costs the same by our account, and is an optimum for us as well."""
    start = along(problem, problem.twist[[0, 2]])
    found = solve(problem, control, half_planes, start=start.inputs)
    there = dataclasses.replace(start, poses=found.poses, inputs=found.inputs)
    assert control.evaluate(problem, there).cost == pytest.approx(found.cost, rel=1e-4, abs=1e-4)
    if not (found.solved and found.settled):
        return 0
    kept = control.solve(problem, there, iterations=60, tolerance=1e-6).evaluation.cost
    assert kept >= 0.99 * found.cost - 1e-3
    return 1


def test_several_hypotheses_bind_in_the_oracle_as_they_do_here():
    rng, planner = np.random.default_rng(8), SsMpcDcbf()
    drawn = [random_problem(rng, people, steps=15) for people in (2, 3, 4, 3)]
    one_wall = [each for each in drawn if (np.abs(each.half_planes[:, 2]) > 500.0).any()]
    met = [
        check_account(with_futures(each.problem), planner.control, each.half_planes)
        for each in one_wall
    ]
    assert sum(met) >= 1


def test_slow_people_need_as_little_clearance_in_the_oracle():
    nowhere = np.array([[1.0, 0.0, -1e3]] * 2)
    clearance = Clearance(oncoming=0.05, deviations=0.5, upper=0.6)
    control = OptimalControl(Terms(), clearance)
    for speed in (0.0, 0.2, 0.45, 0.9):
        here = local_problem(
            steps=25,
            step=0.16,
            people=walkers([[5.6, 4.2, -speed, 0.0]]),
            pose=(4.0, 4.0, 0.0),
            speed=0.6,
        )
        problem = dataclasses.replace(here, walls=field_of(nowhere, here.pose))
        check_account(problem, control, nowhere)


def test_groups_and_a_tracked_reference_cost_the_same_in_the_oracle():
    terms = TrackingTerms(
        track_reference=TrackReference(position=0.4, heading=0.2),
        input_effort=InputDeviation(speed=0.3, turn=0.2),
    )
    rng, met, nowhere = np.random.default_rng(4), 0, np.array([[1.0, 0.0, -1e3]] * 2)
    for _ in range(3):
        problem = random_problem(rng, 3, steps=15).problem
        pair = Groups(id=np.array([7]), member=np.array([0, 0, -1]))
        spaces = PersonalSpace().spaces(
            problem.people, pair, problem.predictions, problem.twist, problem.profile
        )
        assert len(spaces.groups.id) == 1
        grouped = dataclasses.replace(problem, spaces=spaces, walls=field_of(nowhere, problem.pose))
        met += check_account(grouped, OptimalControl(terms, Clearance()), nowhere)
    assert met


def test_the_printed_forms_cost_the_same_in_the_oracle():
    terms = TrackingTerms(input_effort=InputDeviation(input_cost="printed", speed=0.2))
    rng, nowhere = np.random.default_rng(6), np.array([[1.0, 0.0, -1e3]] * 2)
    model = PersonalSpace(PersonalSpace.Parameters(shape="printed"))
    for _ in range(3):
        problem = random_problem(rng, 2, steps=15).problem
        spaces = model.spaces(
            problem.people, Groups.alone(2), problem.predictions, problem.twist, problem.profile
        )
        changed = dataclasses.replace(problem, spaces=spaces)
        changed = dataclasses.replace(changed, walls=field_of(nowhere, problem.pose))
        check_account(changed, OptimalControl(terms, Clearance()), nowhere)


def test_a_term_that_the_oracle_does_not_know_is_refused():
    class Other:
        name = "other"

    drawn = random_problem(np.random.default_rng(2), 0)
    control = OptimalControl(Terms(), Clearance(), extra_terms=[Other()])
    with pytest.raises(ValueError, match="terms of one's own"):
        solve(drawn.problem, control, drawn.half_planes)


def test_three_iterations_find_the_first_command_of_the_optimum():
    rows = [row for people in (1, 5) for row in commands(people, 2, 10, 3)]
    assert len(rows) == 12
    assert np.mean([row["near_converged"] for row in rows]) >= 0.9
    same = [row["near_oracle"] for row in rows if row["verdict"] == OptimumVerdict.SAME]
    assert np.mean(same) >= 0.9


@pytest.mark.parametrize("kind", ["random", "crowded", "hopeless"])
def test_nothing_fails(kind):
    found = failures(kind, 45, 9)
    assert (found["solves"], found["plans"]) == (45, 15)
    assert found["failed"] == found["plans_failed"] == 0
    assert found["ok"] + found["relaxed"] + found["stop"] == 15
