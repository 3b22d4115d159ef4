import dataclasses

import numpy as np
import pytest

from cohelm.benchmarks.solver.comparison import along
from cohelm.benchmarks.solver.programs import minimise, program_at
from cohelm.control import OptimalControl, SsMpcDcbf
from cohelm.control.objective_tables import TERMS
from cohelm.control.stack import Terms, TrackingTerms
from cohelm.control.terms import Barrier, InputDeviation, Progress, TrackReference
from cohelm.robots.clearance import Clearance
from cohelm.testing.problems import mirrored, turned
from cohelm.testing.scenes import local_problem, straight_reference, walkers


def test_the_cost_never_rises_with_the_budget(planner, crowded, motions, rng):
    for problem in crowded:
        seed = motions.wandering(problem, rng)
        costs = [planner.control.evaluate(problem, seed).cost]
        costs += [
            planner.control.solve(problem, seed, iterations=i).evaluation.cost for i in (1, 2, 4, 8)
        ]
        assert (np.diff(costs) <= 1e-12).all()


def test_programs_one_by_one_are_those_of_one_solve(planner, crowded, motions, rng):
    """Each program is made about the present trajectory: nothing but multipliers is carried on."""
    for problem in crowded[:8]:
        seed = motions.wandering(problem, rng)
        whole = planner.control.solve(problem, seed, iterations=3, tolerance=0.0)
        step = seed
        for _ in range(3):
            step = planner.control.solve(problem, step, iterations=1).trajectory
        assert np.abs(whole.trajectory.inputs - step.inputs).max() < 1e-5


def test_a_solution_stays_a_solution(planner, crowded, motions, rng):
    for problem in crowded[:6]:
        seed = motions.wandering(problem, rng)
        first = planner.control.solve(problem, seed, iterations=60, tolerance=1e-6)
        again = planner.control.solve(problem, first.trajectory, iterations=60, tolerance=1e-6)
        assert again.evaluation.cost == pytest.approx(first.evaluation.cost, rel=1e-3, abs=1e-5)


def test_the_budget_is_kept(planner, crowded, motions, rng):
    for problem in crowded[:6]:
        seed = motions.wandering(problem, rng)
        for budget in (1, 3):
            assert planner.control.solve(problem, seed, iterations=budget).iterations <= budget


def test_the_cost_is_the_sum_of_its_terms(planner, crowded, motions, rng):
    for problem in crowded:
        found = planner.control.evaluate(problem, motions.wandering(problem, rng))
        assert tuple(found.costs) == TERMS
        assert found.cost == pytest.approx(sum(found.costs.values()))
        assert min(found.costs.values()) >= 0.0
        assert found.slack >= 0.0


def test_a_quadratic_problem_takes_one_step(motions):
    """Alone, straight ahead, along a line: states are linear in the speeds, so Newton is exact."""
    terms = TrackingTerms(
        progress=Progress(final=0.0, mean=0.0),
        track_reference=TrackReference(position=1.0, heading=0.3),
        input_effort=InputDeviation(speed=0.5),
    )
    problem = local_problem(steps=15, step=0.2, speed=0.5, wanted=0.8)
    seed = dataclasses.replace(motions.standing(problem), current_input=np.array([0.5, 0.0]))
    control = OptimalControl(terms, Clearance())
    # from the first feasible trajectory on: the wheels turn at 0.5 m/s
    start = control.solve(problem, seed, iterations=1)
    best = control.solve(problem, start.trajectory, iterations=20, tolerance=1e-9)
    assert start.evaluation.cost == pytest.approx(best.evaluation.cost, rel=1e-3)


def test_a_barrier_without_a_price_has_no_rows(motions):
    """A person close ahead changes neither the rows nor the cost of bodies."""
    problem = local_problem(steps=15, step=0.2, speed=0.5, people=walkers([[1.5, 0.0, -0.5, 0.0]]))
    none = Barrier(l1=0.0, l2=0.0)
    seed, counts = along(problem, np.array([0.5, 0.0])).inputs, []
    for bodies in (none, Barrier()):
        tables = motions.prepared(problem, Terms(bodies=bodies, social_space=none))
        counts.append(int((program_at(tables, seed).slack >= 0).sum()))
        assert (tables.evaluate(seed).costs["bodies"] > 0.0) == (bodies is not none)
    assert counts[0] == 0 < counts[1]


def test_a_robot_at_rest_comes_up_to_speed(planner):
    """At 0.8 m/s² at most; a little faster than the reference, so as to catch up with it."""
    problem = local_problem(steps=planner.steps, step=planner.step, speed=0.0, wanted=0.9)
    inputs = planner.plan(problem, None).inputs
    assert 0.85 < inputs[-1, 0] <= problem.speed_limit + 1e-9
    assert np.diff(inputs[:, 0]).max() <= 0.8 * planner.step + 1e-6
    assert np.abs(inputs[:, 1]).max() < 0.02


def test_a_reference_to_the_left_is_followed_to_the_left(planner):
    plain = local_problem(steps=planner.steps, step=planner.step, speed=0.6)
    aside = straight_reference(np.array([0.0, 0.5, 0.0]), 0.6, planner.steps, planner.step)
    plan = SsMpcDcbf().plan(dataclasses.replace(plain, reference=aside), None)
    assert plan.inputs[0, 1] > 0.0
    assert plan.poses[-1, 1] > 0.2


def test_at_an_optimum_no_step_lowers_its_program(planner, crowded, motions, rng):
    """Karush, Kuhn, Tucker; to 2 %, as distances have no gradient amid a person."""
    for problem in crowded[:6]:
        found = planner.control.solve(
            problem, motions.wandering(problem, rng), iterations=60, tolerance=1e-7
        )
        tables = motions.prepared(problem)
        given = program_at(tables, found.trajectory.inputs)
        like = planner.control.space(tables.scene, tables.objective)
        step, _ = minimise(given, like)
        gain = given.objective(np.zeros(len(step))) - given.objective(step)
        assert gain < 2e-2 * found.evaluation.cost + 1e-4


def test_a_turned_world_is_solved_alike(planner, crowded):
    """The world turned by a right angle: the same inputs."""
    X = np.array([3.0, -2.0, np.pi / 2])
    for problem in crowded:
        ours, theirs = (
            planner.control.solve(p, along(p, p.twist[[0, 2]]), iterations=1).trajectory.inputs
            for p in (problem, turned(problem, X))
        )
        assert np.abs(ours - theirs).max() < 1e-4


def test_a_mirrored_world_is_solved_mirrored(planner, crowded):
    for problem in crowded:
        ours, theirs = (
            planner.control.solve(p, along(p, p.twist[[0, 2]]), iterations=1).trajectory.inputs
            for p in (problem, mirrored(problem))
        )
        assert np.abs(ours * [1.0, -1.0] - theirs).max() < 1e-4


def test_the_same_problem_gives_the_same_bits(planner, crowded):
    for problem in crowded[:6]:
        seed = along(problem, problem.twist[[0, 2]])
        first, again = (planner.control.solve(problem, seed, iterations=3) for _ in range(2))
        assert first.trajectory.inputs.tobytes() == again.trajectory.inputs.tobytes()


def test_only_the_planned_steps_change(planner, crowded, motions, rng):
    """Beyond N the inputs of a longer horizon stay, and count in the cost."""
    problem = crowded[3]
    seed = motions.wandering(problem, rng)
    tables = planner.control.prepare(problem, seed.current_input, planned=10, steps=25)
    inputs, _ = tables.solve(seed.inputs, iterations=3)
    assert np.array_equal(inputs[10:], seed.inputs[10:])
    assert not np.array_equal(inputs[:10], seed.inputs[:10])
    assert tables.evaluate(inputs).cost <= tables.evaluate(seed.inputs).cost
