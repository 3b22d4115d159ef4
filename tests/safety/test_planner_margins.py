"""The planner asks for no less than the gate, which would else overrule what is verified."""

import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.verification import Verification
from cohelm.safety import GateParameters

PLANNER, GATE = Verification(), GateParameters()


@pytest.mark.parametrize("margin", ["wall_margin", "stalled_wall_margin"])
def test_gaps_to_walls(margin):
    assert getattr(PLANNER, margin) >= GATE.wall_margin


@pytest.mark.parametrize("margin", ["people_margin", "stalled_people_margin"])
def test_gaps_to_people_who_walk_and_who_stand(margin):
    asked = getattr(PLANNER, margin)
    assert asked >= GATE.people_margin
    assert PLANNER.standing_share * asked >= GATE.standing_share * GATE.people_margin


def test_ways_and_plans_aim_at_no_less_than_is_verified_of_who_stands():
    """Of who walks more is verified than is aimed at: there, time is on the planner's side."""
    aims = SsMpcDcbf.Parameters()
    asked = PLANNER.standing_share * PLANNER.people_margin
    assert min(aims.sampling.margin, aims.bodies.margin) >= asked
    squeezing = PLANNER.standing_share * PLANNER.stalled_people_margin
    assert min(aims.sampling.stalled_margin, aims.bodies.stalled_margin) >= squeezing


def test_whatever_future_the_gate_counts_the_planner_does():
    assert PLANNER.min_probability <= GATE.min_probability


def test_braking_begins_no_sooner():
    assert PLANNER.reaction >= GATE.reaction
