"""Terms of one's own: every part of the planner obeys them."""

import math

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.stack import Terms
from cohelm.control.terms import Barrier, WallBarrier, residual
from cohelm.control.terms.extra import HEADING, SPEED, TANGENT, TIME, TURN, D, S, X, Y
from cohelm.errors import ConfigError, ControlError
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem, walkers

STEPS = 12


@residual
def right_of_path(p, z):
    return p[0] * (z[D] + p[1])


class KeepRight:
    """The robot keeps 0.4 m to the right of the path."""

    name = "keep_right"
    residual = right_of_path

    def __init__(self, weight=3.0):
        self.weight = weight

    def table(self, problem):
        return np.array([self.weight, 0.4])


@residual
def everything(p, z):
    return p[0] * (
        z[X] - 0.5 * z[Y] + math.sin(z[HEADING] - z[TANGENT]) + z[SPEED] * z[TURN]
        + 0.1 * z[S] * z[D] + 0.3 * z[TIME]
    )  # fmt: skip


class Everything:
    """A residual of all entries of the state."""

    name = "everything"
    residual = everything

    def table(self, problem):
        return np.array([0.3])


@pytest.fixture(scope="module")
def keeping_right():
    return SsMpcDcbf(extra_terms=[KeepRight()])


def ahead(planner, **scene):
    return local_problem(steps=planner.steps, step=planner.step, speed=0.6, **scene)


def test_cost_by_hand(motions):
    """Straight on the path, 0.4 m beside the wanted line: Δt (3 · 0.4)² a step."""
    tables = motions.prepared(local_problem(steps=STEPS, step=0.2), extra_terms=[KeepRight()])
    found = tables.evaluate(np.tile([0.5, 0.0], (STEPS, 1)))
    assert found.costs["keep_right"] == pytest.approx(STEPS * 0.2 * 1.2**2)
    assert found.cost == pytest.approx(sum(found.costs.values()))


def test_the_model_is_the_derivative_of_the_cost(motions):
    """By position, heading, speed and turn rate; where the projection on the path is smooth."""
    problem = local_problem(steps=STEPS, step=0.2, wanted=0.9)
    no = Barrier(l1=0.0, l2=0.0)
    none = {"bodies": no, "social_space": no, "walls": WallBarrier(l1=0.0, l2=0.0)}
    tables = motions.prepared(
        problem, Terms(**none), np.zeros(2), extra_terms=[Everything(), KeepRight()]
    )
    rng = np.random.default_rng(1)
    for _ in range(4):
        inputs = np.column_stack([rng.uniform(0.1, 0.8, STEPS), rng.normal(0.0, 0.3, STEPS)])
        space, _ = motions.linearised(tables, inputs)
        numeric = motions.slope(lambda u: motions.cost_of(tables, u), inputs)
        assert np.abs(space.program.gradient - numeric).max() < 1e-5
        assert np.linalg.eigvalsh(space.program.hessian).min() > 0.0


def test_it_holds_for_holonomic_robots(motions):
    """Also in both directions of motion, on which the speed depends."""
    problem = motions.any_way(local_problem(steps=STEPS, step=0.2, wanted=0.9))
    terms = [Everything(), KeepRight()]
    tables = motions.prepared(problem, current_input=np.zeros(3), extra_terms=terms)
    for inputs in np.tile([[[0.4, 0.1, 0.05]], [[0.3, -0.4, 0.0]]], (1, STEPS, 1)):
        space, _ = motions.linearised(tables, inputs)
        numeric = motions.slope(lambda u, tables=tables: motions.cost_of(tables, u), inputs)
        assert np.abs(space.program.gradient - numeric).max() < 1e-5


def test_the_sqp_follows_it(motions):
    problem = local_problem(steps=STEPS, step=0.2, speed=0.5)
    inputs, ends = np.tile([0.5, 0.0], (STEPS, 1)), []
    for terms in ([], [KeepRight()]):
        tables = motions.prepared(problem, extra_terms=terms)
        solved, _ = tables.solve(inputs, iterations=10)
        ends.append(tables.trajectory(solved).poses[-1, 1])
    assert abs(ends[0]) < 0.02
    assert ends[1] < -0.2


def test_sampling_follows_it(planner, keeping_right):
    """The best samples, before the SQP, pass to the right of the straight ones."""
    problem = ahead(planner)
    aside = []
    for each in (planner, keeping_right):
        cycle = each._prepare(problem, None)
        best = cycle.sample(each.parameters.sampling, None)[0]
        aside.append(best.poses[: STEPS + 1, 1].mean())
    assert abs(aside[0]) < 0.02
    assert aside[1] < -0.04


def test_the_choice_follows_it(planner, keeping_right):
    """On a free floor, and past a person who stands on the path."""
    problem = ahead(planner)
    plain, right = planner.plan(problem, None), keeping_right.plan(problem, None)
    assert abs(plain.poses[-1, 1]) < 0.05
    assert right.poses[-1, 1] < -0.2
    people = walkers([[3.0, 0.0, 0.0, 0.0]])
    passing = SsMpcDcbf(extra_terms=[KeepRight(8.0)]).plan(ahead(planner, people=people), None)
    assert passing.poses[:, 1].mean() < -0.1


class Recording(SsMpcDcbf):
    """It keeps the candidate that became the plan."""

    chosen = None

    def _as_plan(self, cycle, chosen, iterations, *, resampled=False):
        self.chosen = chosen
        return super()._as_plan(cycle, chosen, iterations, resampled=resampled)


def test_the_costs_of_a_plan_name_it_and_sum_to_its_score():
    planner = Recording(extra_terms=[KeepRight(), Everything()])
    rng = np.random.default_rng(2)
    for people in (0, 3):
        problem = random_problem(rng, people, steps=planner.steps, step=planner.step).problem
        plan = planner.plan(problem, None)
        assert {"keep_right", "everything", "progress", "switching"} <= plan.costs.keys()
        assert plan.costs["keep_right"] > 0.0
        assert sum(plan.costs.values()) == pytest.approx(planner.chosen.score)


def test_a_term_of_weight_0_changes_no_bit(planner):
    problem = ahead(planner, people=walkers([[3.0, 0.5, -0.5, 0.0]]))
    found = SsMpcDcbf(extra_terms=[KeepRight(0.0)]).plan(problem, None)
    assert found.inputs.tobytes() == planner.plan(problem, None).inputs.tobytes()


class Renamed(KeepRight):
    name = "progress"


class NotCompiled(KeepRight):
    name = "not_compiled"
    residual = staticmethod(lambda p, z: 0.0)


class Undefined(KeepRight):
    name = "undefined"

    def table(self, problem):
        return np.array([np.nan, 0.4])


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        (KeepRight(), "a list of terms"),
        ([KeepRight], "no instance"),
        ([KeepRight(), KeepRight()], "another term of the name 'keep_right'"),
        ([Renamed()], "another term of the name 'progress'"),
        ([NotCompiled()], "'not_compiled' is not made by @residual"),
    ],
)
def test_a_term_that_cannot_work_is_refused(terms, message):
    with pytest.raises(ConfigError, match=message):
        SsMpcDcbf(extra_terms=terms)


def test_a_table_without_numbers_is_an_error_and_no_stand(planner):
    with pytest.raises(ControlError, match="'undefined' is not of finite numbers"):
        SsMpcDcbf(extra_terms=[Undefined()]).plan(ahead(planner), None)
