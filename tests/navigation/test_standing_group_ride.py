"""A ride past three people who stand and talk."""

from cohelm.evaluation import run
from cohelm.scenarios import load_scenario


def test_the_chair_goes_round_three_who_talk():
    seen = []
    ride = run(
        load_scenario("talking", ["group_detector=affinity"]), 0, lambda tick, _: seen.append(tick)
    )
    assert ride.outcome == "reached"
    # from there on they hide each other
    whole = [tick for tick in seen if 2.0 < tick.observation.time < 5.0]
    assert whole
    # one group of all three, under one id
    assert {tuple(tick.groups.id.tolist()) for tick in whole} == {(0,)}
    assert all(tick.groups.member.tolist() == [0, 0, 0] for tick in whole)
    assert ride.gap_people.min() > 0.3
