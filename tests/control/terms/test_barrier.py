import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cohelm.control.terms.constraints import barrier

VALUES = hnp.arrays(float, (3, 6), elements=st.floats(-2.0, 3.0))
GAMMA = st.floats(0.05, 1.0)


@given(VALUES, GAMMA)
def test_rows_are_eq_9(h, gamma):
    """g_k = h_{k+1} − (1 − γ) h_k, and its derivative by the chain rule; those above NEAR apart."""
    rng = np.random.default_rng(0)
    gradient, sensitivity = rng.normal(size=(3, 6, 3)), rng.normal(size=(6, 3, 10))
    for k in range(6):
        sensitivity[k, :, 2 * k :] = 0.0  # two inputs a step, which move later poses only
    each = barrier.separate_slacks(3)
    margin, jacobian, slack_index, row_id = barrier.linearise_dcbf(
        h, gradient, sensitivity, gamma, barrier.NEAR, each
    )
    slope = np.einsum("ska,kaj->skj", gradient, sensitivity)
    all_margins = h[:, 1:] - (1.0 - gamma) * h[:, :-1]
    all_slopes = slope[:, 1:] - (1.0 - gamma) * slope[:, :-1]
    near = all_margins < barrier.NEAR
    assert row_id.tolist() == np.flatnonzero(near).tolist()
    assert slack_index.tolist() == (row_id // 5).tolist()
    assert np.abs(margin - all_margins[near]).max(initial=0.0) < 1e-12
    assert np.abs(jacobian - all_slopes[near]).max(initial=0.0) < 1e-12


@given(VALUES, GAMMA)
def test_the_slack_needed_is_the_worst_row(h, gamma):
    needed, smallest = barrier.largest_violations(h, gamma, barrier.separate_slacks(len(h)))
    margins = h[:, 1:] - (1.0 - gamma) * h[:, :-1]
    assert np.abs(needed - np.maximum(-margins.min(axis=1), 0.0)).max() < 1e-12
    assert smallest == h.min()


@given(st.floats(0.01, 3.0), GAMMA)
def test_a_barrier_that_just_holds_never_changes_sign(start, gamma):
    h = start * (1.0 - gamma) ** np.arange(6)[None]
    needed, smallest = barrier.largest_violations(h, gamma, barrier.separate_slacks(len(h)))
    assert needed[0] < 1e-12
    assert smallest >= 0.0


def test_gamma_1_is_a_plain_distance_constraint():
    needed, _ = barrier.largest_violations(
        np.array([[5.0, 0.0, 4.0, -0.25]]), 1.0, barrier.separate_slacks(1)
    )
    assert needed.tolist() == [0.25]


def test_nobody_needs_no_slack():
    needed, smallest = barrier.largest_violations(np.empty((0, 6)), 0.3, barrier.separate_slacks(0))
    assert needed.shape == (0,)
    assert smallest == np.inf
