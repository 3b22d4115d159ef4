"""The planner asks for no less than the gate, which would else overrule what is verified."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.control import SsMpcDcbf
from cohelm.control.verification import MIN_PROBABILITY, REACTION
from cohelm.robots.clearance import CLOSEST, Clearance
from cohelm.safety import GateParameters
from cohelm.testing.scenes import local_problem

PLANNER, GATE = SsMpcDcbf.Parameters().verification, GateParameters()


@pytest.mark.parametrize("stalled", [False, True])
def test_gaps_to_walls(stalled):
    problem = dataclasses.replace(local_problem(steps=24, step=0.16), stalled=stalled)
    assert PLANNER.wall_margin_of(problem) >= GATE.wall_margin


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
    assert GATE.min_probability >= MIN_PROBABILITY


def test_braking_begins_no_sooner():
    assert GATE.reaction <= REACTION
