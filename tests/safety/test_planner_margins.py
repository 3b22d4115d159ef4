"""The planner asks for no less than the gate, which would else overrule what is verified."""

import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.verification import Verification
from cohelm.safety import GateParameters

PLANNER, GATE = Verification(), GateParameters()


@pytest.mark.parametrize("margin", ["wall_margin", "squeezing_wall_margin"])
def test_gaps_to_walls(margin):
    assert getattr(PLANNER, margin) >= GATE.margin


@pytest.mark.parametrize("margin", ["people_margin", "squeezing_margin"])
def test_gaps_to_people_who_walk_and_who_stand(margin):
    asked = getattr(PLANNER, margin)
    assert asked >= GATE.people_margin
    assert PLANNER.standing * asked >= GATE.standing * GATE.people_margin


def test_ways_and_plans_aim_at_no_less_than_is_verified_of_who_stands():
    """Of who walks more is verified than is aimed at: there, time is on the planner's side."""
    aims = SsMpcDcbf.Parameters()
    asked = PLANNER.standing * PLANNER.people_margin
    assert min(aims.arcs.margin, aims.bodies.margin) >= asked
    squeezing = PLANNER.standing * PLANNER.squeezing_margin
    assert min(aims.arcs.squeezing, aims.bodies.squeezing) >= squeezing


def test_whatever_future_the_gate_counts_the_planner_does():
    assert PLANNER.at_least <= GATE.at_least


def test_braking_begins_no_sooner():
    assert PLANNER.reaction >= GATE.reaction
