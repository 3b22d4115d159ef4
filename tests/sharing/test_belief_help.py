"""Help towards the belief: bounded, growing with certainty, nothing where the stick disagrees."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.sharing import BeliefHelpParameters, helped_deflection

P = BeliefHelpParameters(use=True)
AHEAD = np.array([0.5, 0.0])


def test_it_grows_with_certainty_up_to_its_bound():
    # halfway between 0.7 and 0.95: half of min(0.6 · 1 rad, 0.3)
    assert helped_deflection(AHEAD, 0.825, 1.0, P)[1] == pytest.approx(0.15)
    assert helped_deflection(AHEAD, 1.0, 1.0, P)[1] == pytest.approx(0.3)
    assert helped_deflection(AHEAD, 0.7, 1.0, P) is AHEAD


@pytest.mark.parametrize("stick", [(0.5, -0.1), (0.0, 0.0), (-0.5, 0.0), (0.0, 0.2)])
def test_it_is_nothing_at_once_where_the_stick_disagrees_or_rests(stick):
    stick = np.array(stick)
    assert helped_deflection(stick, 1.0, 1.0, P) is stick


def test_it_is_off_by_default():
    assert helped_deflection(AHEAD, 1.0, 1.0, BeliefHelpParameters()) is AHEAD


@given(st.floats(0.01, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 1.0), st.floats(-3.0, 3.0))
def test_it_changes_only_the_turn_within_its_bound(forward, left, certainty, angle):
    stick = np.array([forward, left])
    helped = helped_deflection(stick, certainty, angle, P)
    assert helped[0] == forward
    assert helped[1] == left or abs(helped[1]) <= P.largest
    mirrored = helped_deflection(np.array([forward, -left]), certainty, -angle, P)
    np.testing.assert_array_equal(mirrored, helped * (1.0, -1.0))
