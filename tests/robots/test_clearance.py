"""One model of the clearance from people: m(t, v) by its formula, and its parts."""

import numpy as np
import pytest

from cohelm.robots.clearance import Clearance, people_margins
from cohelm.testing.scenes import straight_on, walkers

STEPS, STEP = 30, 0.16
TIMES = STEP * np.arange(STEPS + 1)


def margins(clearance, *velocities, known=STEPS, **situation):
    """m(t) of people who walk with some velocities, (n, STEPS + 1)."""
    people = walkers([[0.0, 0.0, *velocity] for velocity in velocities])
    p = straight_on(people, known, STEP)
    velocity = np.ascontiguousarray(p.velocity)
    deviation = np.ascontiguousarray(p.deviation)
    return people_margins(velocity, deviation, STEP, STEPS, clearance.law(**situation))


def test_a_walking_persons_margin_grows_up_to_its_bound():
    clearance = Clearance(now=0.1, growth=0.05, upper=0.25)
    [found] = margins(clearance, (0.0, -0.8))
    assert found == pytest.approx(np.minimum(0.1 + 0.05 * TIMES, 0.25))


@pytest.mark.parametrize(("speed", "share"), [(0.0, 0.4), (0.25, 0.7), (0.5, 1.0), (1.5, 1.0)])
def test_a_slow_persons_margin_is_a_share(speed, share):
    """0.4 of it at rest, all of it from 0.5 m/s on."""
    clearance = Clearance(now=0.1, growth=0.05, upper=0.25, standing=0.4)
    [found] = margins(clearance, (speed, 0.0))
    assert found == pytest.approx(share * np.minimum(0.1 + 0.05 * TIMES, 0.25))


def test_uncertain_people_have_a_wider_margin():
    """The deviation is 5 cm and grows by 0.1 m/s; beyond the prediction it stays."""
    clearance = Clearance(now=0.1, growth=0.0, upper=2.0, deviations=2.0)
    [found] = margins(clearance, (0.8, 0.0), known=10)
    assert found == pytest.approx(0.1 + 2.0 * (0.05 + 0.1 * np.minimum(TIMES, 10 * STEP)))


def test_oncoming_people_have_a_wider_margin():
    clearance = Clearance(now=0.1, growth=0.05, oncoming=0.2, upper=3.0)
    [found] = margins(clearance, (-0.8, 0.0), oncoming=0.5)
    assert found == pytest.approx(0.1 + 0.15 * TIMES)


@pytest.mark.parametrize("tight", [True, False])
def test_a_therapists_distance_is_added_at_any_time(tight):
    clearance = Clearance()
    [plain] = margins(clearance, (0.8, 0.0), tight=tight)
    [farther] = margins(clearance, (0.8, 0.0), tight=tight, extra=0.3)
    assert farther - plain == pytest.approx(np.full(STEPS + 1, 0.3))


def test_in_a_tight_passage_the_margin_does_not_grow():
    """It is the gate's: what the gate lets pass must be planned."""
    clearance = Clearance(deviations=1.0, oncoming=0.5)
    [found] = margins(clearance, (0.8, 0.0), tight=True, oncoming=1.0)
    assert found == pytest.approx(np.full(STEPS + 1, clearance.after(0.0)))


def test_the_gap_after_some_time_is_that_of_the_margins():
    clearance = Clearance()
    [found] = margins(clearance, (0.8, 0.0))
    assert [clearance.after(time) for time in TIMES] == pytest.approx(found)


def test_nobody_has_no_margin():
    assert margins(Clearance()).shape == (0, STEPS + 1)


def test_an_upper_bound_below_the_present_gap_does_not_reduce_it():
    assert Clearance(now=0.5, upper=0.1).after(3.0) == 0.5
