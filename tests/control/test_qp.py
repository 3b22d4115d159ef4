import numpy as np
import pytest
from scipy.optimize import minimize, nnls

from cohelm.control.qp import Multipliers, QuadraticProgram, minimise
from cohelm.errors import SolverFailed

FAR = 1e6


def program(rng, *, inputs=6, rows=12, groups=3, hard=2):
    """Any program with a solution: x = 0 keeps the box and the hard rows."""
    root = rng.normal(size=(inputs, inputs))
    group = np.concatenate([np.full(hard, -1), rng.integers(0, groups, rows - hard)])
    margin = np.where(group < 0, rng.uniform(0.0, 0.5, rows), rng.normal(0.0, 0.5, rows))
    return QuadraticProgram(
        hessian=root @ root.T + 0.1 * np.eye(inputs),
        gradient=3.0 * rng.normal(size=inputs),
        low=-rng.uniform(0.2, 1.0, inputs),
        high=rng.uniform(0.2, 1.0, inputs),
        jacobian=rng.normal(size=(rows, inputs)),
        margin=margin,
        upper=np.where(group < 0, rng.uniform(0.2, 0.5, rows), FAR),
        slack_index=group,
        row_id=rng.permutation(rows + 5)[:rows],
        num_row_ids=rows + 5,
        l1=rng.uniform(0.1, 2.0, groups),
        l2=rng.uniform(0.1, 2.0, groups),
    )


def solved(given, start=None):
    return minimise(given, start or Multipliers.none(given))


def slack_of(given, x):
    """What each group needs at x."""
    soft = given.slack_index >= 0
    out = np.zeros(len(given.l1))
    np.maximum.at(out, given.slack_index[soft], -(given.jacobian @ x + given.margin)[soft])
    return out


def whole(given):
    """The program in (x, s): H, f, and A z + b ≥ 0 with every row, bound and slack."""
    n, groups = len(given.gradient), len(given.l1)
    hessian = np.block(
        [[given.hessian, np.zeros((n, groups))], [np.zeros((groups, n)), np.diag(given.l2)]]
    )
    eye, none = np.eye(n), np.zeros((n, groups))
    select = (given.slack_index[:, None] == np.arange(groups)).astype(float)
    hard = given.slack_index < 0
    a = np.vstack(
        [
            np.hstack([given.jacobian, select]),
            np.hstack([-given.jacobian[hard], np.zeros((int(hard.sum()), groups))]),
            np.hstack([eye, none]),
            np.hstack([-eye, none]),
            np.hstack([np.zeros((groups, n)), np.eye(groups)]),
        ]
    )
    b = [given.margin, given.upper[hard], -given.low, given.high, np.zeros(groups)]
    return hessian, np.concatenate([given.gradient, given.l1]), a, np.concatenate(b)


def check_optimal(given, x):
    """Karush, Kuhn, Tucker: for a convex program they are enough.

    Feasible, and the gradient is a non-negative sum of those of the active rows.
    """
    hessian, gradient, a, b = whole(given)
    z = np.concatenate([x, slack_of(given, x)])
    gap = a @ z + b
    assert gap.min() > -1e-6
    active = gap < 1e-6
    _, rest = nnls(a[active].T, hessian @ z + gradient)
    assert rest < 1e-5


@pytest.mark.parametrize("seed", range(20))
def test_the_solution_is_optimal(seed):
    given = program(np.random.default_rng(seed))
    check_optimal(given, solved(given)[0])


@pytest.mark.parametrize("seed", range(5))
def test_scipy_finds_the_same(seed):
    given = program(np.random.default_rng(seed), inputs=4, rows=8)
    hessian, gradient, a, b = whole(given)
    other = minimize(
        lambda z: 0.5 * z @ hessian @ z + gradient @ z,
        np.concatenate([np.zeros(4), slack_of(given, np.zeros(4))]),
        jac=lambda z: hessian @ z + gradient,
        constraints={"type": "ineq", "fun": lambda z: a @ z + b, "jac": lambda _: a},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert other.success
    assert np.abs(solved(given)[0] - other.x[:4]).max() < 1e-5


@pytest.mark.parametrize("seed", range(8))
def test_rows_brought_in_as_needed_give_the_whole_program_its_solution(seed):
    """Four hundred rows, of which the first solve takes 48: all the same none is violated."""
    rng = np.random.default_rng(seed)
    given = program(rng, inputs=20, rows=400, groups=12, hard=6)
    given = given._replace(margin=given.margin + rng.uniform(0.0, 4.0, 400))
    check_optimal(given, solved(given)[0])


@pytest.mark.parametrize("seed", range(8))
def test_where_it_starts_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    given = program(rng, inputs=10, rows=60)
    other = given._replace(gradient=given.gradient + rng.normal(size=10))
    warm, _ = solved(other, solved(given)[1])
    assert np.abs(warm - solved(other)[0]).max() < 1e-6


def test_the_order_of_the_rows_does_not_matter(rng):
    given = program(rng, inputs=10, rows=60)
    order = rng.permutation(60)
    named = ("jacobian", "margin", "upper", "slack_index", "row_id")
    mixed = given._replace(**{name: getattr(given, name)[order] for name in named})
    assert np.abs(solved(mixed)[0] - solved(given)[0]).max() < 1e-6


def test_by_hand():
    """min ½ (x − 2)² + 3 s + ½ s²  s.t.  x ≤ 1 + s: slack costs 3, x pulls with 1."""
    given = QuadraticProgram(
        hessian=np.eye(1),
        gradient=np.array([-2.0]),
        low=np.array([-5.0]),
        high=np.array([5.0]),
        jacobian=np.array([[-1.0]]),
        margin=np.array([1.0]),
        upper=np.array([FAR]),
        slack_index=np.array([0]),
        row_id=np.array([0]),
        num_row_ids=1,
        l1=np.array([3.0]),
        l2=np.array([1.0]),
    )
    assert solved(given)[0] == pytest.approx([1.0])
    # cheaper slack yields: 2 − x = l1 + s with s = x − 1 and l1 = 0.4, so x = 1.3
    assert solved(given._replace(l1=np.array([0.4])))[0] == pytest.approx([1.3])


def test_hard_rows_that_contradict_each_other_are_said_so():
    rng = np.random.default_rng(0)
    given = program(rng, hard=2)
    jacobian, margin = given.jacobian.copy(), given.margin.copy()
    jacobian[1], margin[:2] = -jacobian[0], -1.0  # a x ≥ 1 and −a x ≥ 1
    with pytest.raises(SolverFailed, match="no solution"):
        solved(given._replace(jacobian=jacobian, margin=margin))


def test_programs_of_crowds_are_solved_whole(planner, crowded, motions, rng):
    """With every row in, hundreds of them, none is violated and the gradient is balanced."""
    for problem in crowded[3:9]:
        trajectory = motions.wandering(problem, rng)
        given = planner.control.program(
            problem, trajectory, planner.control.evaluate(problem, trajectory)
        )
        x, multipliers = solved(given)
        hessian, gradient, a, b = whole(given)
        z = np.concatenate([x, slack_of(given, x)])
        assert (a @ z + b).min() > -1e-5
        # starting from its own multipliers it stays
        again, _ = solved(given, multipliers)
        worth = [0.5 * y @ hessian @ y + gradient @ y for y in (z, parted(given, again))]
        assert worth[1] == pytest.approx(worth[0], rel=1e-6, abs=1e-6)
        # and no other way to choose the first rows leads lower
        other = parted(given, solved(given, all_rows(given))[0])
        value = 0.5 * other @ hessian @ other + gradient @ other
        assert value == pytest.approx(worth[0], rel=1e-6, abs=1e-6)


def parted(given, x):
    return np.concatenate([x, slack_of(given, x)])


def all_rows(given):
    """Multipliers that bring every row in from the beginning, and bind none of them by much."""
    start = Multipliers.none(given)
    start.rows[given.row_id] = -1e-9
    return start
