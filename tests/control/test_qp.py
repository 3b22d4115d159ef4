"""Quadratic programs by DAQP, whose rows are added on demand."""

import numpy as np
import pytest
from scipy.optimize import minimize, nnls

from cohelm.benchmarks.solver.programs import Duals, QuadraticProgram, minimise, program_at
from cohelm.errors import SolverFailed
from cohelm.testing.scenes import local_problem

FAR = 1e6


@pytest.fixture(scope="module")
def like(motions):
    """Any workspace, for the types of its arrays."""
    tables = motions.prepared(local_problem(steps=3, step=0.2))
    return tables.control.space(tables.scene, tables.objective)


def program(rng, *, inputs=6, rows=12, slacks=3, hard=2):
    """A random program with a solution: x = 0 satisfies the bounds and the hard rows."""
    root = rng.normal(size=(inputs, inputs))
    slack = np.concatenate([np.full(hard, -1), rng.integers(0, slacks, rows - hard)])
    margin = np.where(slack < 0, rng.uniform(0.0, 0.5, rows), rng.normal(0.0, 0.5, rows))
    return QuadraticProgram(
        hessian=root @ root.T + 0.1 * np.eye(inputs),
        gradient=3.0 * rng.normal(size=inputs),
        low=-rng.uniform(0.2, 1.0, inputs),
        high=rng.uniform(0.2, 1.0, inputs),
        jacobian=rng.normal(size=(rows, inputs)),
        margin=margin,
        upper=np.where(slack < 0, rng.uniform(0.2, 0.5, rows), FAR),
        slack=slack,
        key=rng.permutation(rows + 5)[:rows],
        l1=rng.uniform(0.1, 2.0, slacks),
        l2=rng.uniform(0.1, 2.0, slacks),
    )


def whole(given):
    """The program in (x, s): H, f, and A z + b ≥ 0 with every row, bound and slack."""
    n, slacks = len(given.gradient), len(given.l1)
    hessian = np.block(
        [[given.hessian, np.zeros((n, slacks))], [np.zeros((slacks, n)), np.diag(given.l2)]]
    )
    eye, none = np.eye(n), np.zeros((n, slacks))
    select = (given.slack[:, None] == np.arange(slacks)).astype(float)
    hard = given.slack < 0
    a = np.vstack(
        [
            np.hstack([given.jacobian, select]),
            np.hstack([-given.jacobian[hard], np.zeros((int(hard.sum()), slacks))]),
            np.hstack([eye, none]),
            np.hstack([-eye, none]),
            np.hstack([np.zeros((slacks, n)), np.eye(slacks)]),
        ]
    )
    b = [given.margin, given.upper[hard], -given.low, given.high, np.zeros(slacks)]
    return hessian, np.concatenate([given.gradient, given.l1]), a, np.concatenate(b)


def check_optimal(given, x):
    """Karush, Kuhn, Tucker: sufficient for a convex program.

    Feasible, and the gradient is a non-negative sum of those of the active rows.
    """
    hessian, gradient, a, b = whole(given)
    z = np.concatenate([x, given.slacks(x)])
    gap = a @ z + b
    assert gap.min() > -1e-6
    active = gap < 1e-6
    _, rest = nnls(a[active].T, hessian @ z + gradient)
    assert rest < 1e-5


@pytest.mark.parametrize("seed", range(20))
def test_the_solution_is_optimal(seed, like):
    given = program(np.random.default_rng(seed))
    check_optimal(given, minimise(given, like)[0])


@pytest.mark.parametrize("seed", range(5))
def test_scipy_finds_the_same(seed, like):
    given = program(np.random.default_rng(seed), inputs=4, rows=8)
    hessian, gradient, a, b = whole(given)
    other = minimize(
        lambda z: 0.5 * z @ hessian @ z + gradient @ z,
        np.concatenate([np.zeros(4), given.slacks(np.zeros(4))]),
        jac=lambda z: hessian @ z + gradient,
        constraints={"type": "ineq", "fun": lambda z: a @ z + b, "jac": lambda _: a},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert other.success
    assert np.abs(minimise(given, like)[0] - other.x[:4]).max() < 1e-5


@pytest.mark.parametrize("seed", range(8))
def test_rows_added_on_demand_give_the_solution_of_the_whole_program(seed, like):
    """Four hundred rows, of which the first solve uses 96 at most: none is violated."""
    rng = np.random.default_rng(seed)
    given = program(rng, inputs=20, rows=400, slacks=12, hard=6)
    given = given._replace(margin=given.margin + rng.uniform(0.0, 4.0, 400))
    check_optimal(given, minimise(given, like)[0])


@pytest.mark.parametrize("seed", range(8))
def test_the_start_does_not_matter(seed, like):
    rng = np.random.default_rng(seed)
    given = program(rng, inputs=10, rows=60)
    other = given._replace(gradient=given.gradient + rng.normal(size=10))
    warm, _ = minimise(other, like, minimise(given, like)[1])
    assert np.abs(warm - minimise(other, like)[0]).max() < 1e-6


def test_the_order_of_the_rows_does_not_matter(rng, like):
    given = program(rng, inputs=10, rows=60)
    order = rng.permutation(60)
    named = ("jacobian", "margin", "upper", "slack", "key")
    mixed = given._replace(**{name: getattr(given, name)[order] for name in named})
    assert np.abs(minimise(mixed, like)[0] - minimise(given, like)[0]).max() < 1e-6


def test_by_hand(like):
    """min ½ (x − 2)² + 3 s + ½ s²  s.t.  x ≤ 1 + s: slack costs 3, x pulls with 1."""
    given = QuadraticProgram(
        hessian=np.eye(1),
        gradient=np.array([-2.0]),
        low=np.array([-5.0]),
        high=np.array([5.0]),
        jacobian=np.array([[-1.0]]),
        margin=np.array([1.0]),
        upper=np.array([FAR]),
        slack=np.array([0]),
        key=np.array([0]),
        l1=np.array([3.0]),
        l2=np.array([1.0]),
    )
    assert minimise(given, like)[0] == pytest.approx([1.0])
    # a cheaper slack yields: 2 − x = l1 + s with s = x − 1 and l1 = 0.4, so x = 1.3
    assert minimise(given._replace(l1=np.array([0.4])), like)[0] == pytest.approx([1.3])


def test_contradicting_hard_rows_are_reported(like):
    given = program(np.random.default_rng(0), hard=2)
    jacobian, margin = given.jacobian.copy(), given.margin.copy()
    jacobian[1], margin[:2] = -jacobian[0], -1.0  # a x ≥ 1 and −a x ≥ 1
    with pytest.raises(SolverFailed, match="no solution"):
        minimise(given._replace(jacobian=jacobian, margin=margin), like)


def test_programs_of_crowds_are_solved_with_all_rows(crowded, motions, rng, like):
    """Hundreds of rows: none is violated, and the choice of the first ones does not matter."""
    for problem in crowded[3:9]:
        given = program_at(motions.prepared(problem), motions.wandering(problem, rng).inputs)
        x, duals = minimise(given, like)
        _, _, a, b = whole(given)
        assert (a @ np.concatenate([x, given.slacks(x)]) + b).min() > -1e-5
        best = pytest.approx(given.objective(x), rel=1e-6, abs=1e-6)
        assert given.objective(minimise(given, like, duals)[0]) == best
        # multipliers that differ from 0 put every row into the first program
        every = Duals(duals.inputs, duals.slacks, np.full(len(duals.rows), -1e-9))
        assert given.objective(minimise(given, like, every)[0]) == best
