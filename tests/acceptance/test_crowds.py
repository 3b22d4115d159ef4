"""Crowds seen in a ride, and crowds known beforehand."""

import pytest

from cohelm.evaluation import Outcome, run
from cohelm.scenarios import load_scenario


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(s, marks=pytest.mark.slow) for s in range(1, 6))]
)
@pytest.mark.slow
def test_the_chair_takes_the_other_corridor_once(seed):
    ride = run(load_scenario("crowded"), seed)
    assert ride.outcome is Outcome.REACHED
    assert ride.path.points[:, 1].max() < 4.0  # the shorter corridor
    assert len(ride.replans) == 1
    assert ride.replans[0].points[:, 1].max() > 6.5  # the other one
    assert ride.hit_moving.sum() == 0
