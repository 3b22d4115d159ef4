"""The planner asks for no less than the gate, which would else overrule what is verified."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.control import SsMpcDcbf
from cohelm.robots.clearance import CLOSEST, Clearance
from cohelm.safety import GateParameters

PLANNER, GATE = SsMpcDcbf.Parameters().verification, GateParameters()


@pytest.mark.parametrize("margin", ["wall_margin", "stalled_wall_margin"])
def test_gaps_to_walls(margin):
    assert getattr(PLANNER, margin) >= GATE.wall_margin


@given(
    st.builds(
        Clearance,
        now=st.floats(0.0, 1.0),
        growth=st.floats(0.0, 0.3),
        upper=st.floats(0.0, 1.0),
        standing=st.floats(0.0, 1.0),
    ),
    st.booleans(),
)
def test_gaps_to_people_whatever_the_clearance(clearance, tight):
    """Both take the share of a standing person from the clearance, so these gaps decide."""
    law = clearance.law(tight=tight)
    assert PLANNER.clearance_share * law.now >= CLOSEST * clearance.now
    assert law.growth >= 0.0


def test_whatever_future_the_gate_counts_the_planner_does():
    assert PLANNER.min_probability <= GATE.min_probability


def test_braking_begins_no_sooner():
    assert PLANNER.reaction >= GATE.reaction
