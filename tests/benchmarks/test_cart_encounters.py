"""Recorded and simulated people near a cart."""

import numpy as np
import pytest

from cohelm.benchmarks.cart_encounters import STEP, Recording, manners, simulated
from cohelm.simulation import Orca

FRAMES = np.arange(300) * STEP


def straight(start, velocity):
    return np.asarray(start) + FRAMES[:, None] * np.asarray(velocity)


CART = np.column_stack([straight([-10.0, 0.0], [2.0, 0.0]), np.zeros(300), np.full(300, 2.0)])


def test_manners_of_two_people_beside_a_cart():
    meets = straight([8.0, 3.0], [-1.0, 0.0])
    # At half speed from y = 1 to 0, which they reach at 3 s, when the cart is 4 m away.
    crosses = np.column_stack([np.zeros(300), np.interp(FRAMES, [0, 1, 3, 10], [2, 1, 0, -7])])
    found = manners(np.stack([meets, crosses], axis=1), CART)
    assert found.gap[0] == pytest.approx(3.0 - 0.6 - 0.25)
    assert found.slowing == pytest.approx([0.0, 0.5], abs=0.05)
    assert found.side_step == pytest.approx([0.0, 0.0], abs=1e-9)
    assert np.isnan(found.ahead[0])
    assert found.ahead[1] == 1.0


def test_simulated_people_avoid_the_recorded_cart():
    people = straight([6.0, 0.2], [-1.0, 0.0])[:, None]
    walked = simulated(Orca(), Recording(people, CART))
    assert walked.shape == people.shape
    assert manners(people, CART).gap[0] < 0.0
    assert manners(walked, CART).gap[0] > 0.3  # m
