import dataclasses

import numpy as np
import pytest

from cohelm.control import OptimalControl, SsMpcDcbf
from cohelm.control.qp import Multipliers, minimise
from cohelm.control.terms import (
    InputEffort,
    InputLimits,
    PersonBarrier,
    SmoothInput,
    TrackReference,
)
from cohelm.testing.comparison import along
from cohelm.testing.problems import mirrored, turned
from cohelm.testing.scenes import local_problem, straight_reference


def test_the_merit_never_rises_with_the_budget(planner, crowded, motions, rng):
    for problem in crowded:
        seed = motions.wandering(problem, rng)
        merits = [planner.control.evaluate(problem, seed).merit]
        merits += [
            planner.control.solve(problem, seed, iterations=i).evaluation.merit
            for i in (1, 2, 4, 8)
        ]
        assert (np.diff(merits) <= 1e-12).all()


def test_what_is_solved_stays_so(planner, crowded, motions, rng):
    for problem in crowded[:6]:
        seed = motions.wandering(problem, rng)
        first = planner.control.solve(problem, seed, iterations=60, tolerance=1e-6)
        again = planner.control.solve(problem, first.trajectory, iterations=60, tolerance=1e-6)
        assert again.evaluation.merit == pytest.approx(first.evaluation.merit, rel=1e-3, abs=1e-6)


def test_the_budget_is_kept(planner, crowded, motions, rng):
    for problem in crowded[:6]:
        seed = motions.wandering(problem, rng)
        for budget in (1, 3):
            assert planner.control.solve(problem, seed, iterations=budget).iterations <= budget


def test_the_value_is_the_sum_of_its_parts(planner, crowded, motions, rng):
    for problem in crowded:
        value = planner.control.evaluate(problem, motions.wandering(problem, rng))
        assert value.merit == pytest.approx(sum(value.costs.values()))
        assert value.slack >= 0.0


def test_a_linear_problem_takes_one_step(motions):
    """Alone, straight ahead, along a line: states are linear in the speeds, so Newton is exact."""
    control = OptimalControl([TrackReference(), InputEffort(), SmoothInput()], [InputLimits()])
    problem = local_problem(steps=15, step=0.2, speed=0.5, wanted=0.8)
    seed = dataclasses.replace(motions.standing(problem), current_input=np.array([0.5, 0.0]))
    # from the first feasible motion on: the wheels turn at 0.5 m/s
    start = control.solve(problem, seed, iterations=1)
    best = control.solve(problem, start.trajectory, iterations=20, tolerance=1e-9)
    assert start.evaluation.merit == pytest.approx(best.evaluation.merit, rel=1e-3)


def test_terms_can_be_left_out_and_put_in(motions):
    """The assembler knows none by name: without its constraint a person has no effect."""
    problem = local_problem(steps=15, step=0.2, speed=0.5)
    costs = [TrackReference(), InputEffort(), SmoothInput()]
    seed = dataclasses.replace(motions.standing(problem), current_input=np.array([0.5, 0.0]))
    alone = OptimalControl(costs, [InputLimits()]).solve(problem, seed, iterations=5)
    nobody = OptimalControl(costs, [InputLimits(), PersonBarrier()]).solve(
        problem, seed, iterations=5
    )
    assert np.array_equal(alone.trajectory.inputs, nobody.trajectory.inputs)
    assert set(alone.evaluation.costs) == {"track_reference", "input_effort", "smooth_input"}


def test_a_chair_at_rest_comes_up_to_speed(planner):
    """At 0.8 m/s² at most; a little faster than the reference, so as to catch up with it."""
    problem = local_problem(steps=planner.steps, step=planner.step, speed=0.0, wanted=0.9)
    inputs = planner.plan(problem, None).inputs
    assert 0.9 < inputs[-1, 0] <= problem.speed_limit + 1e-9
    assert np.diff(inputs[:, 0]).max() <= 0.8 * planner.step + 1e-6
    assert np.abs(inputs[:, 1]).max() < 1e-6


def test_a_reference_to_the_left_is_followed_to_the_left(planner):
    """Turning first is not asked for; the chair curves on to a line 0.5 m aside."""
    plain = local_problem(steps=planner.steps, step=planner.step, speed=0.6)
    aside = straight_reference(np.array([0.0, 0.5, 0.0]), 0.6, planner.steps, planner.step)
    plan = SsMpcDcbf().plan(dataclasses.replace(plain, reference=aside), None)
    assert plan.inputs[0, 1] > 0.0
    assert plan.poses[-1, 1] == pytest.approx(0.5, abs=0.1)


def test_where_it_ends_it_stays_by_its_own_program(planner, crowded, motions, rng):
    """Karush, Kuhn, Tucker: at an optimum no step lowers the quadratic program of that place."""
    for problem in crowded[:6]:
        found = planner.control.solve(
            problem, motions.wandering(problem, rng), iterations=60, tolerance=1e-7
        )
        program = planner.control.program(problem, found.trajectory, found.evaluation)
        step, _ = minimise(program, Multipliers.none(program))
        # what the step would gain, by the program's own account
        gain = -(0.5 * step @ program.hessian @ step + program.gradient @ step)
        slack = sum(
            c.l1 * m.slack.sum() + 0.5 * c.l2 * m.slack @ m.slack
            for c, m in zip(planner.control.constraints, found.evaluation.constraints, strict=True)
        )
        left = needed(program, step)
        gain += slack - (program.l1 @ left + 0.5 * left @ (program.l2 * left))
        assert gain < 1e-3 * found.evaluation.merit + 1e-6


def needed(program, step):
    """The slack of each group after a step."""
    soft = program.slack_index >= 0
    out = np.zeros(len(program.l1))
    np.maximum.at(out, program.slack_index[soft], -(program.jacobian @ step + program.margin)[soft])
    return out


def test_a_turned_world_is_solved_alike(planner, crowded):
    """The world turned by a right angle: the same inputs."""
    X = np.array([3.0, -2.0, np.pi / 2])
    for problem in crowded:
        other = turned(problem, X)
        ours, theirs = (
            planner.control.solve(p, along(p, p.twist[[0, 2]]), iterations=2).trajectory.inputs
            for p in (problem, other)
        )
        assert np.abs(ours - theirs).max() < 1e-4


def test_a_mirrored_world_is_solved_mirrored(planner, crowded):
    for problem in crowded:
        other = mirrored(problem)
        ours, theirs = (
            planner.control.solve(p, along(p, p.twist[[0, 2]]), iterations=2).trajectory.inputs
            for p in (problem, other)
        )
        assert np.abs(ours * [1.0, -1.0] - theirs).max() < 1e-4


def test_the_same_problem_gives_the_same_bits(planner, crowded, motions):
    for problem in crowded[:6]:
        seed = along(problem, problem.twist[[0, 2]])
        first, again = (planner.control.solve(problem, seed, iterations=3) for _ in range(2))
        assert first.trajectory.inputs.tobytes() == again.trajectory.inputs.tobytes()


def test_a_seed_of_known_value_is_not_valued_again(planner, crowded):
    problem = crowded[4]
    seed = along(problem, problem.twist[[0, 2]])
    value = planner.control.evaluate(problem, seed)
    plain, told = (
        planner.control.solve(problem, seed, iterations=2, evaluation=v) for v in (None, value)
    )
    assert plain.trajectory.inputs.tobytes() == told.trajectory.inputs.tobytes()
    assert plain.evaluation.merit == told.evaluation.merit
